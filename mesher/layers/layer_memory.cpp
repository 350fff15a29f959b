#include "mesher/layers/layer_memory.hpp"

#include <algorithm>
#include <sstream>
#include <vector>

#include "core/sizing/memory_check.hpp"
#include "mesher/layers/walls.hpp"
#include "tetloom/error.hpp"

namespace tetloom::layers {
namespace {

// Measured: vertices, region and three fields of a prism, half a point, and arrays that grow.
constexpr double kBytesPerCell = 140;

// As LayerCounts would have them with room without end.
int highest_count(const LayerHeights& heights, double width) {
  int count = heights.count;
  while (count > 1 && heights.last(count) > width) --count;
  return count;
}

}  // namespace

void check_layer_memory(const GeometricModel& model, const Mesh& mesh, const LayerOptions& options,
                        std::uint64_t max_memory) {
  const Walls walls = find_walls(mesh, model.topology().face_to_sides, options);
  std::vector<int> counts;
  for (std::size_t c = 0; c < walls.curve_count(); ++c)
    counts.push_back(highest_count(walls.curve_to_heights[c], walls.curve_to_width[c]));
  std::vector<double> cells_of_face(model.topology().face_count(), 0);
  std::vector<std::uint32_t> triangle_of_face(cells_of_face.size(), 0);
  double cells = 0;
  for (const WallTriangle& wall : walls.triangles) {
    const double height = std::max({counts[wall.curves[0]], counts[wall.curves[1]], counts[wall.curves[2]]});
    const std::uint32_t face = mesh.tri_to_entity[wall.triangle];
    cells += height;
    cells_of_face[face] += height;
    triangle_of_face[face] = wall.triangle;
  }
  const std::uint64_t limit = max_memory > 0 ? max_memory : available_memory();
  if (limit == 0 || kBytesPerCell * cells <= static_cast<double>(limit)) return;
  const auto worst = static_cast<std::uint32_t>(std::ranges::max_element(cells_of_face) - cells_of_face.begin());
  std::ostringstream message;
  message.precision(3);
  message << "the layers would have about " << cells << " cells and need " << kBytesPerCell * cells / 1e9
          << " GB of memory, but " << static_cast<double>(limit) / 1e9 << " GB are "
          << (max_memory > 0 ? "allowed" : "free") << "; ask for fewer of them, or for larger sizes";
  throw Error(Diagnostic{ErrorCode::OutOfMemory,
                         message.str(),
                         {model.named(ModelFaceId(worst))},
                         mesh.points[mesh.tri_to_vert[triangle_of_face[worst]][0]],
                         {}});
}

}  // namespace tetloom::layers

#include "mesher/volume/volume_parts.hpp"

#include <algorithm>
#include <numeric>

#include "mesher/volume/volume_parts_detail.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::volume {

void keep_as_parts(const Complex& complex, FilledComplex& filled) {
  if (!filled.filling) return;
  Filling& filling = *filled.filling;
  VolumePart& part = filled.parts.emplace_back();
  filled.part_count = 1;
  filled.new_points = filling.points.size() - complex.points.size();
  part.points.append(std::span<const Vec3>(filling.points));
  part.vert_to_number.resize_for_overwrite(filling.points.size());
  std::iota(part.vert_to_number.begin(), part.vert_to_number.end(), std::uint64_t{0});
  filling.points = {};
  part.tet_to_vert.resize_for_overwrite(4 * filling.tet_to_vert.size());
  for (std::size_t tet = 0; tet < filling.tet_to_vert.size(); ++tet)
    std::copy_n(filling.tet_to_vert[tet].data(), 4, part.tet_to_vert.data() + 4 * tet);
  filling.tet_to_vert = {};
  part.tet_to_region.append(std::span<const std::uint32_t>(filling.tet_to_region));
  filled.filling.reset();
  part.triangles.resize(complex.tri_to_vert.size());
  std::iota(part.triangles.begin(), part.triangles.end(), 0u);
  part.tri_to_vert = filled.tri_to_vert.empty() ? complex.tri_to_vert : std::move(filled.tri_to_vert);
}

// Both lists of the complex ascend, so that triangles stay in order.
void to_numbers_of_input(const Complex& complex, std::uint64_t first_new, std::span<VolumePart> parts,
                         const TaskRunner& runner) {
  const std::uint64_t given = complex.points.size();
  runner.for_each(parts.size(), [&](std::size_t i) {
    for (std::uint64_t& number : parts[i].vert_to_number)
      number = number < given ? complex.to_input_vert[number] : number - given + first_new;
    for (std::uint32_t& triangle : parts[i].triangles) triangle = complex.to_input_tri[triangle];
  });
}

}  // namespace tetloom::volume

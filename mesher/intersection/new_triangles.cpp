#include "mesher/intersection/new_triangles.hpp"

#include <algorithm>
#include <array>

#include "tetloom/tasks.hpp"
#include "threading/runtime/parallel_sort.hpp"

namespace tetloom {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 13;

}  // namespace

KnownTriangles::Key KnownTriangles::key_of(const Mesh& surface, std::size_t triangle) {
  std::array<std::array<double, 3>, 3> corners;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& x = surface.points[surface.tri_to_vert[triangle][i]];
    corners[i] = {x.x, x.y, x.z};
  }
  std::ranges::rotate(corners, std::ranges::min_element(corners));
  Key key{.face = surface.tri_to_entity[triangle]};
  for (std::size_t i = 0; i < 9; ++i) key.coordinates[i] = corners[i / 3][i % 3];
  return key;
}

KnownTriangles::KnownTriangles(const Mesh& surface, const TaskRunner& runner) : keys_(surface.tri_to_vert.size()) {
  runner.for_blocks(keys_.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) keys_[t] = key_of(surface, t);
  });
  parallel_sort(keys_, runner);
}

std::vector<std::uint8_t> KnownTriangles::find_new(const Mesh& surface, const TaskRunner& runner) const {
  if (keys_.empty()) return {};
  std::vector<std::uint8_t> is_new(surface.tri_to_vert.size());
  runner.for_blocks(is_new.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) is_new[t] = !std::ranges::binary_search(keys_, key_of(surface, t));
  });
  return is_new;
}

}  // namespace tetloom

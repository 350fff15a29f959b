#include "mesher/surface/faces_touched.hpp"

#include <algorithm>
#include <cmath>

#include "core/spatial/bvh.hpp"

namespace tetloom {
namespace {

// A face's triangles, each with what lies beside it as far as its longest edge.
class TriangleReaches {
 public:
  TriangleReaches(const FaceMesh& face, const RimNodes& rim) : face_(face), rim_(rim) {}

  Box3 of_all() const {
    Box3 box;
    for (const auto& tri : face_.tri_to_vert) box.add(of(tri));
    return box;
  }

  template <class Test>
  bool any(const Test& test) const {
    return std::ranges::any_of(face_.tri_to_vert, [&](const auto& tri) { return test(of(tri)); });
  }

 private:
  Vec3 place(std::uint32_t v) const {
    return v & FaceMesh::kInner ? face_.points[v & ~FaceMesh::kInner] : rim_.point(v);
  }

  Box3 of(const std::array<std::uint32_t, 3>& tri) const {
    const Vec3 x = place(tri[0]), y = place(tri[1]), z = place(tri[2]);
    const double reach = std::sqrt(std::max({norm2(y - x), norm2(z - y), norm2(x - z)}));
    Box3 box;
    for (const Vec3& corner : {x, y, z}) box.add(corner);
    return {box.lo - Vec3{reach, reach, reach}, box.hi + Vec3{reach, reach, reach}};
  }

  const FaceMesh& face_;
  const RimNodes& rim_;
};

}  // namespace

std::vector<bool> find_faces_touched(std::span<const Box3> changes, std::span<const FaceMesh> faces,
                                     const RimNodes& rim, const TaskRunner& runner) {
  const Bvh bvh = build_bvh(changes, runner);
  const auto is_changed = [&](const Box3& box) {
    return any_near(bvh, box, [&](std::uint32_t change) { return changes[change].overlaps(box); });
  };
  std::vector<std::uint8_t> touched(faces.size(), 0);
  runner.for_each(faces.size(), [&](std::size_t f) {
    const TriangleReaches around(faces[f], rim);
    const Box3 box = around.of_all();
    touched[f] = !box.empty() && is_changed(box) && around.any(is_changed);
  });
  return {touched.begin(), touched.end()};
}

}  // namespace tetloom

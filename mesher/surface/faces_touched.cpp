#include "mesher/surface/faces_touched.hpp"

#include <algorithm>
#include <cmath>

#include "core/spatial/bvh.hpp"

namespace tetloom {
namespace {

Box3 box_around(const FaceMesh& face, const RimNodes& rim) {
  const auto place = [&](std::uint32_t v) {
    return v & FaceMesh::kInner ? face.points[v & ~FaceMesh::kInner] : rim.point(v);
  };
  Box3 box;
  double longest2 = 0;
  for (const auto& [a, b, c] : face.tri_to_vert) {
    const Vec3 x = place(a), y = place(b), z = place(c);
    for (const Vec3& corner : {x, y, z}) box.add(corner);
    longest2 = std::max({longest2, norm2(y - x), norm2(z - y), norm2(x - z)});
  }
  if (box.empty()) return box;
  const double reach = std::sqrt(longest2);
  return {box.lo - Vec3{reach, reach, reach}, box.hi + Vec3{reach, reach, reach}};
}

}  // namespace

std::vector<bool> find_faces_touched(std::span<const Box3> changes, std::span<const FaceMesh> faces,
                                     const RimNodes& rim, const TaskRunner& runner) {
  constexpr std::size_t kBlock = std::size_t{1} << 13;
  std::vector<Box3> boxes(faces.size());
  runner.for_each(faces.size(), [&](std::size_t f) { boxes[f] = box_around(faces[f], rim); });
  std::vector<std::size_t> box_to_face;
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (!boxes[f].empty()) box_to_face.push_back(f);
  std::erase_if(boxes, [](const Box3& box) { return box.empty(); });
  const Bvh bvh = build_bvh(boxes, runner);
  std::vector<std::vector<bool>> block_to_touched((changes.size() + kBlock - 1) / kBlock);
  runner.for_blocks(changes.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    std::vector<bool>& touched = block_to_touched[begin / kBlock];
    touched.resize(boxes.size());
    for (std::size_t i = begin; i < end; ++i)
      for_each_near(bvh, changes[i], [&](std::uint32_t box) {
        if (!touched[box]) touched[box] = changes[i].overlaps(boxes[box]);
      });
  });
  std::vector<bool> result(faces.size());
  for (const std::vector<bool>& touched : block_to_touched)
    for (std::size_t box = 0; box < touched.size(); ++box)
      if (touched[box]) result[box_to_face[box]] = true;
  return result;
}

}  // namespace tetloom

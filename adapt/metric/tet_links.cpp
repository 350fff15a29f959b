#include "adapt/metric/tet_links.hpp"

#include <algorithm>

#include "core/base/assert.hpp"

namespace tetloom::adapt {
namespace {

constexpr std::size_t kGrain = 1 << 12;

struct FaceKey {
  std::uint32_t low, middle, high;
};

FaceKey key_of(const TetVerts& tet, std::size_t face) {
  std::array<std::uint32_t, 3> v;
  for (std::size_t i = 0; i < 3; ++i) v[i] = tet[kFaceVerts[face][i]];
  if (v[0] > v[1]) std::swap(v[0], v[1]);
  if (v[1] > v[2]) std::swap(v[1], v[2]);
  if (v[0] > v[1]) std::swap(v[0], v[1]);
  return {v[0], v[1], v[2]};
}

}  // namespace

std::vector<std::uint32_t> link_tets(const TetView& mesh, const BlockLoop& loop) {
  TETLOOM_ASSERT(mesh.tets.size() < (std::size_t{1} << 30));
  // Faces sorted by their lowest vertex, by counting; those of one vertex are matched with each other.
  std::vector<std::size_t> begins(mesh.points.size() + 2);
  for (const TetVerts& tet : mesh.tets)
    for (std::size_t f = 0; f < 4; ++f) ++begins[key_of(tet, f).low + 2];
  for (std::size_t v = 2; v < begins.size(); ++v) begins[v] += begins[v - 1];
  std::vector<std::uint32_t> faces(mesh.tets.size() * 4);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (std::size_t f = 0; f < 4; ++f)
      faces[begins[key_of(mesh.tets[t], f).low + 1]++] = static_cast<std::uint32_t>(4 * t + f);

  std::vector<std::uint32_t> links(mesh.tets.size() * 4, kNone);
  loop.for_blocks(mesh.points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> of_vert;
    for (std::size_t v = begin; v < end; ++v) {
      of_vert.clear();
      for (std::size_t k = begins[v]; k < begins[v + 1]; ++k) {
        const FaceKey key = key_of(mesh.tets[faces[k] / 4], faces[k] % 4);
        of_vert.emplace_back(std::uint64_t{key.middle} << 32 | key.high, faces[k]);
      }
      std::sort(of_vert.begin(), of_vert.end());
      for (std::size_t i = 0; i + 1 < of_vert.size();) {
        const bool same = of_vert[i].first == of_vert[i + 1].first;
        if (same) links[of_vert[i].second] = of_vert[i + 1].second, links[of_vert[i + 1].second] = of_vert[i].second;
        i += same ? 2 : 1;
        while (same && i < of_vert.size() && of_vert[i].first == of_vert[i - 1].first) ++i;
      }
    }
  });
  return links;
}

}  // namespace tetloom::adapt

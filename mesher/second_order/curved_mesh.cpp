#include "mesher/second_order/curved_mesh.hpp"

#include <algorithm>

#include "core/base/lists.hpp"

namespace tetloom::second_order {
namespace {

constexpr std::size_t kGrain = std::size_t{1} << 13;

}  // namespace

std::vector<std::uint32_t> CurvedMesh::find_bad(std::span<const std::uint32_t> tets) const {
  const auto find = [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& found) {
    for (std::size_t i = begin; i < end; ++i)
      if (!is_good(tets[i])) found.push_back(tets[i]);
  };
  return joined(map_blocks(runner_, tets.size(), kGrain, std::vector<std::uint32_t>{}, find));
}

// A tet has the mid node of an edge only if both ends are among its vertices.
std::vector<MidAndTet> CurvedMesh::tets_at(std::span<const std::uint32_t> mids) const {
  std::vector<std::uint8_t> is_end(first_mid_, 0), is_wanted(mesh_.mid_to_vert.size(), 0);
  for (const std::uint32_t mid : mids) {
    is_wanted[mid] = 1;
    for (const std::uint32_t v : mesh_.mid_to_vert[mid]) is_end[v] = 1;
  }
  const auto collect = [&](std::size_t begin, std::size_t end, std::vector<MidAndTet>& pairs) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto& verts = mesh_.tet_to_vert[t];
      if (std::ranges::count_if(verts, [&](std::uint32_t v) { return is_end[v] != 0; }) < 2) continue;
      const auto tet = static_cast<std::uint32_t>(t);
      for (const std::uint32_t mid : mids_of(tet))
        if (is_wanted[mid] != 0) pairs.emplace_back(mid, tet);
    }
  };
  auto pairs = joined(map_blocks(runner_, mesh_.tet_to_vert.size(), kGrain, std::vector<MidAndTet>{}, collect));
  std::ranges::sort(pairs);
  return pairs;
}

std::vector<std::uint32_t> tets_of(std::span<const MidAndTet> pairs) {
  std::vector<std::uint32_t> tets;
  tets.reserve(pairs.size());
  for (const auto& [mid, tet] : pairs) tets.push_back(tet);
  sort_unique(tets);
  return tets;
}

std::vector<std::uint32_t> mids_of(std::span<const CurvedNode> curved) {
  std::vector<std::uint32_t> mids;
  for (const CurvedNode& node : curved) mids.push_back(node.mid);
  return mids;
}

}  // namespace tetloom::second_order

#include "threading/balance/partition_figures.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <set>

#include "tetloom/error.hpp"
#include "threading/balance/pair_refinement_detail.hpp"

namespace tetloom {

namespace {

double imbalance_of(std::span<const std::int64_t> values) {
  const std::int64_t sum = std::accumulate(values.begin(), values.end(), std::int64_t{0});
  if (sum == 0) return 0;
  const auto most = static_cast<double>(*std::max_element(values.begin(), values.end()));
  return most * static_cast<double>(values.size()) / static_cast<double>(sum) - 1;
}

/// Tets grouped by target, so that one stamp per vertex is enough to count it once in each.
std::vector<std::int64_t> count_vertices(const TargetedTets& tets, std::span<const std::int64_t> elements,
                                         std::span<const std::uint32_t> tet_to_vert, std::size_t vertex_count) {
  std::vector<std::size_t> next(elements.size(), 0);
  for (std::size_t p = 1; p < next.size(); ++p) next[p] = next[p - 1] + static_cast<std::size_t>(elements[p - 1]);
  std::vector<std::uint32_t> order(tets.targets.size());
  for (std::uint32_t tet = 0; tet < order.size(); ++tet) order[next[tets.targets[tet]]++] = tet;
  std::vector<std::uint32_t> stamp(vertex_count, tets.part_count);
  std::vector<std::int64_t> vertices(elements.size(), 0);
  for (const std::uint32_t tet : order)
    for (int corner = 0; corner < 4; ++corner) {
      const std::uint32_t part = tets.targets[tet], v = tet_to_vert[4 * std::size_t{tet} + corner];
      if (v >= vertex_count) throw Error(ErrorCode::InvalidArgument, "a tet names a vertex that there is not");
      if (stamp[v] == part) continue;
      stamp[v] = part;
      ++vertices[part];
    }
  return vertices;
}

}  // namespace

PartitionFigures measure_partition(const TargetedTets& tets, std::span<const std::uint32_t> tet_to_vert,
                                   std::size_t vertex_count) {
  balance_detail::check_tets(tets, nullptr);
  PartitionFigures figures;
  figures.elements.assign(tets.part_count, 0);
  figures.neighbours.assign(tets.part_count, 0);
  figures.weights = balance_detail::weights_by_target(tets, nullptr);
  std::set<std::array<std::uint32_t, 2>> pairs;
  std::array<std::uint32_t, 2> last{};
  for (std::size_t tet = 0; tet < tets.targets.size(); ++tet) {
    const std::uint32_t own = tets.targets[tet];
    ++figures.elements[own];
    for (int face = 0; face < 4; ++face) {
      const std::uint32_t code = tets.neighbours[4 * tet + face];
      if (code == TargetedTets::kNoNeighbour || tets.targets[code >> 2] <= own) continue;
      ++figures.cut_faces;
      const std::array pair{own, tets.targets[code >> 2]};
      if (pair != last) pairs.insert(pair);
      last = pair;
    }
  }
  for (const auto& pair : pairs)
    for (const std::uint32_t part : pair) ++figures.neighbours[part];
  figures.element_imbalance = imbalance_of(figures.elements);
  figures.weight_imbalance = imbalance_of(figures.weights);
  if (tet_to_vert.empty()) return figures;
  if (tet_to_vert.size() != 4 * tets.targets.size())
    throw Error(ErrorCode::InvalidArgument, "every tet needs four vertices");
  figures.vertices = count_vertices(tets, figures.elements, tet_to_vert, vertex_count);
  figures.vertex_imbalance = imbalance_of(figures.vertices);
  return figures;
}

}  // namespace tetloom

#include "mesher/second_order/curved_mesh.hpp"

#include <algorithm>
#include <utility>

#include "core/base/grain.hpp"
#include "core/base/lists.hpp"

namespace tetloom::second_order {
CurvedMesh::CurvedMesh(Mesh& mesh, double least, const TaskRunner& runner)
    : mesh_(mesh), mids_(mesh), first_mid_(vertex_count(mesh)), least_(least), runner_(runner) {
  for_each_cell_kind(std::as_const(mesh), [&](CellKind kind, const auto& cells, const auto&) {
    if (kind == CellKind::Tet || cells.empty()) return;
    is_of_layers_.resize(mesh.mid_to_vert.size(), false);
    for (const auto& verts : cells)
      for (const std::uint32_t mid : CellMids(kind, verts, mids_)) is_of_layers_[mid] = true;
  });
}

CurvedMesh::CellVerts CurvedMesh::verts_of(std::uint32_t cell) const {
  CellVerts found{};
  std::size_t first = 0;
  for_each_cell_kind(std::as_const(mesh_), [&](CellKind kind, const auto& cells, const auto&) {
    if (cell >= first && cell - first < cells.size()) found = {kind, cells[cell - first]};
    first += cells.size();
  });
  return found;
}

CellMids CurvedMesh::mids_of(std::uint32_t cell) const {
  if (is_tet(cell)) return CellMids(CellKind::Tet, mesh_.tet_to_vert[cell], mids_);
  const auto [kind, verts] = verts_of(cell);
  return CellMids(kind, verts, mids_);
}

bool CurvedMesh::is_straight(std::uint32_t cell) const {
  if (is_tet(cell)) return is_straight_tet(mesh_, mids_, cell);
  const auto [kind, verts] = verts_of(cell);
  return curved_cell_of(mesh_, mids_, kind, verts).is_straight();
}

double CurvedMesh::least_jacobian_of(std::uint32_t cell) const {
  if (is_tet(cell)) return least_jacobian(jacobian_of(cell), least_);
  const auto [kind, verts] = verts_of(cell);
  return least_jacobian(cell_jacobian(curved_cell_of(mesh_, mids_, kind, verts)), least_);
}

std::vector<std::uint32_t> CurvedMesh::find_bad(std::span<const std::uint32_t> cells) const {
  const auto find = [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& found) {
    for (std::size_t i = begin; i < end; ++i)
      if (!is_good(cells[i])) found.push_back(cells[i]);
  };
  return joined(map_blocks(runner_, cells.size(), kElementGrain, std::vector<std::uint32_t>{}, find));
}

// A cell has the mid node of an edge only if both ends are among its vertices.
std::vector<MidAndCell> CurvedMesh::cells_at(std::span<const std::uint32_t> mids) const {
  std::vector<std::uint8_t> is_end(first_mid_, 0), is_wanted(mesh_.mid_to_vert.size(), 0);
  for (const std::uint32_t mid : mids) {
    is_wanted[mid] = 1;
    for (const std::uint32_t v : mesh_.mid_to_vert[mid]) is_end[v] = 1;
  }
  std::vector<MidAndCell> pairs;
  std::size_t first = 0;
  for_each_cell_kind(std::as_const(mesh_), [&](CellKind kind, const auto& cells, const auto&) {
    const auto collect = [&](std::size_t begin, std::size_t end, std::vector<MidAndCell>& found) {
      for (std::size_t c = begin; c < end; ++c) {
        if (!has_two_of(cells[c], is_end)) continue;
        for (const std::uint32_t mid : CellMids(kind, cells[c], mids_))
          if (is_wanted[mid] != 0) found.emplace_back(mid, static_cast<std::uint32_t>(first + c));
      }
    };
    const auto found = joined(map_blocks(runner_, cells.size(), kElementGrain, std::vector<MidAndCell>{}, collect));
    pairs.insert(pairs.end(), found.begin(), found.end());
    first += cells.size();
  });
  std::ranges::sort(pairs);
  return pairs;
}

std::vector<std::uint32_t> cells_of(std::span<const MidAndCell> pairs) {
  std::vector<std::uint32_t> cells;
  cells.reserve(pairs.size());
  for (const auto& [mid, cell] : pairs) cells.push_back(cell);
  sort_unique(cells);
  return cells;
}

std::vector<std::uint32_t> mids_of(std::span<const CurvedNode> curved) {
  std::vector<std::uint32_t> mids;
  for (const CurvedNode& node : curved) mids.push_back(node.mid);
  return mids;
}

}  // namespace tetloom::second_order

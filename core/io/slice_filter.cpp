#include "core/io/slice_filter_detail.hpp"

#include <algorithm>
#include <utility>

#include "core/base/lists.hpp"

namespace tetloom::detail {

namespace {

// Leaves those elements that are sides of tets: their edges, or their faces.
template <std::size_t N, class ForEachSide>
void keep_sides(std::vector<std::array<std::uint32_t, N>>& elements, std::vector<std::uint32_t>& entities,
                std::size_t points, const ForEachSide& for_each_side) {
  using Side = std::array<std::uint32_t, N>;
  const auto key_of = [](Side side) {
    std::ranges::sort(side);
    return side;
  };
  std::vector<Side> keys;
  std::vector<bool> is_used(points + 1, false);  // the last: points of other slices
  for (const Side& element : elements) {
    keys.push_back(key_of(element));
    for (const std::uint32_t v : element) is_used[v] = true;
  }
  sort_unique(keys);
  std::vector<bool> is_side(keys.size(), false);
  for_each_side([&](const Side& side) {
    if (!std::ranges::all_of(side, [&](std::uint32_t v) { return is_used[v]; })) return;
    const auto at = std::ranges::lower_bound(keys, key_of(side));
    if (at != keys.end() && *at == key_of(side)) is_side[static_cast<std::size_t>(at - keys.begin())] = true;
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const auto at = std::ranges::lower_bound(keys, key_of(elements[i])) - keys.begin();
    if (is_side[static_cast<std::size_t>(at)]) elements[kept] = elements[i], entities[kept++] = entities[i];
  }
  elements.resize(kept), entities.resize(kept);
}

void keep_sides_of_tets(Mesh& mesh) {
  const CellShape& shape = shape_of(CellKind::Tet);
  keep_sides(mesh.tri_to_vert, mesh.tri_to_entity, mesh.points.size(), [&](const auto& visit) {
    for (const auto& tet : mesh.tet_to_vert)
      for (const LocalFace& face : shape.faces()) visit({tet[face.vert[0]], tet[face.vert[1]], tet[face.vert[2]]});
  });
  keep_sides(mesh.edge_to_vert, mesh.edge_to_entity, mesh.points.size(), [&](const auto& visit) {
    for (const auto& tet : mesh.tet_to_vert)
      for (const auto& [a, b] : shape.edges()) visit({tet[a], tet[b]});
  });
}

}  // namespace

void SliceFilter::expect(Block block, std::uint64_t count) {
  if (!wants(block) || count == 0) return;
  if (block == Block::Tet) {
    file_.tets += count;
    first_tet_ = file_.tets * index_ / count_, last_tet_ = file_.tets * (index_ + 1) / count_;
  } else if (block == Block::Triangle) {
    file_.triangles += count;
  } else if (block == Block::Edge) {
    file_.edges += count;
  } else {
    set_unfit();
  }
}

void SliceFilter::begin_second_pass(const Mesh& mesh) {
  is_first_pass_ = false;
  if (file_.tets < count_) set_unfit();
  points_.reserve(mesh.tet_to_vert.size() * 4);
  for (const auto& tet : mesh.tet_to_vert) points_.insert(points_.end(), tet.begin(), tet.end());
  sort_unique(points_);
  if (!points_.empty() && points_.back() >= file_.points) set_unfit();
}

std::uint32_t SliceFilter::local_of(std::uint64_t point) const {
  const auto at = std::ranges::lower_bound(points_, point);
  const bool is_there = at != points_.end() && *at == point;
  return static_cast<std::uint32_t>((is_there ? at : points_.end()) - points_.begin());
}

// Points of other slices are all one behind the slice's own.
void SliceFilter::renumber(Mesh& mesh) const {
  for_each_block(mesh, [&](Block, auto& elements, const auto&) {
    for (auto& element : elements)
      for (std::uint32_t& v : element) v = local_of(v);
  });
}

std::optional<FileSlice> SliceFilter::finish(Mesh&& mesh, std::span<const Corner> corners, bool points_are_classified) {
  if (!is_fit() || mesh.points.size() != points_.size()) return {};
  renumber(mesh);
  if (!points_are_classified) {
    std::vector<Corner> own;
    for (const Corner& corner : corners)
      if (keeps_point(corner.point)) own.push_back({local_of(corner.point), corner.index});
    mesh.points.emplace_back();
    classify_points(mesh, own);
    mesh.points.pop_back(), mesh.point_to_entity.pop_back();
  }
  keep_sides_of_tets(mesh);
  return FileSlice{{std::move(mesh), std::move(points_)}, file_};
}

}  // namespace tetloom::detail

// Numbers the vertices and tets of a part anew.
#include <algorithm>

#include "adapt/kernel/cavity_mesh.hpp"
#include "core/spatial/hilbert.hpp"

namespace tetloom::adapt {

namespace {

template <class T>
void permute(GrowingArray<T>& array, std::span<const std::uint32_t> sources) {
  GrowingArray<T> result;
  result.reserve(sources.size() + sources.size() / 4);
  for (const std::uint32_t source : sources) result.push_back(array[source]);
  array = std::move(result);
}

}  // namespace

// Those that have tets, in their order or along a Hilbert curve.
GrowingArray<std::uint32_t> CavityMesh::find_verts(bool along_curve) const {
  GrowingArray<std::uint32_t> found;
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v)
    if (vert_to_tet[v] != kNone) found.push_back(v);
  if (!along_curve) return found;
  Box3 box;
  for (const std::uint32_t v : found) box.add(mesh.points[v]);
  const Vec3 extent = box.hi - box.lo;
  const double scale = ((1 << kHilbertBits) - 1) / std::max({extent.x, extent.y, extent.z, 1e-300});
  struct Place {
    std::uint64_t key;
    std::uint32_t vert;
    auto operator<=>(const Place&) const = default;
  };
  GrowingArray<Place> order;
  order.reserve(found.size());
  for (const std::uint32_t v : found) {
    const Vec3 x = scale * (mesh.points[v] - box.lo);
    order.push_back(
        {hilbert_key(static_cast<std::int64_t>(x.x), static_cast<std::int64_t>(x.y), static_cast<std::int64_t>(x.z)),
         v});
  }
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < found.size(); ++i) found[i] = order[i].vert;
  return found;
}

// Those that are not dead, in their order or by their lowest vertices.
GrowingArray<std::uint32_t> CavityMesh::find_tets(bool by_verts) const {
  GrowingArray<std::uint32_t> found;
  for (std::uint32_t tet = 0; tet < mesh.size(); ++tet)
    if (!mesh.is_dead(tet)) found.push_back(tet);
  if (!by_verts) return found;
  // The lowest vertex of each decides its bucket, the next one its place there.
  std::vector<std::uint32_t> ends(mesh.points.size() + 1, 0);
  const auto lowest = [&](std::uint32_t tet) {
    const std::uint32_t* v = verts(tet);
    return std::min(std::min(v[0], v[1]), std::min(v[2], v[3]));
  };
  for (const std::uint32_t tet : found) ++ends[lowest(tet) + 1];
  for (std::size_t v = 1; v < ends.size(); ++v) ends[v] += ends[v - 1];
  GrowingArray<std::uint64_t> order;
  order.resize_for_overwrite(found.size());
  for (const std::uint32_t tet : found) {
    const std::uint32_t least = lowest(tet);
    std::uint32_t second = kNone;
    for (int j = 0; j < 4; ++j)
      if (verts(tet)[j] != least) second = std::min(second, verts(tet)[j]);
    order[ends[least]++] = std::uint64_t{second} << 32 | tet;
  }
  for (std::size_t v = 0, begin = 0; v + 1 < ends.size(); begin = ends[v++])
    std::sort(order.data() + begin, order.data() + ends[v]);
  for (std::size_t i = 0; i < found.size(); ++i) found[i] = static_cast<std::uint32_t>(order[i]);
  return found;
}

// The arrays of vertices as `sources` says; tets then have the new numbers.
void CavityMesh::permute_verts(std::span<const std::uint32_t> sources) {
  GrowingArray<std::uint32_t> to_new;
  to_new.resize(mesh.points.size(), kNone);
  for (std::size_t i = 0; i < sources.size(); ++i) to_new[sources[i]] = static_cast<std::uint32_t>(i);
  permute(mesh.points, sources), permute(to_metric, sources), permute(to_entity, sources), permute(to_hint, sources);
  permute(to_frozen, sources), permute(to_state, sources);
  vert_to_tet.resize(sources.size());
  surface.renumber(to_new.span());
  for (std::uint32_t tet = 0; tet < mesh.size(); ++tet) {
    if (mesh.is_dead(tet)) continue;
    for (std::size_t j = 0; j < 4; ++j) mesh.to_vert[std::size_t{tet} * 4 + j] = to_new[verts(tet)[j]];
  }
}

void CavityMesh::permute_tets(std::span<const std::uint32_t> sources) {
  GrowingArray<std::uint32_t> to_new;
  to_new.resize(mesh.size(), kNone);
  for (std::size_t i = 0; i < sources.size(); ++i) to_new[sources[i]] = static_cast<std::uint32_t>(i);
  GrowingArray<std::uint32_t> to_vert;
  GrowingArray<FaceCode> to_neighbor;
  to_vert.reserve(sources.size() * 5), to_neighbor.reserve(sources.size() * 5);
  for (const std::uint32_t tet : sources) {
    for (std::size_t j = 0; j < 4; ++j) {
      const FaceCode behind = mesh.behind({tet, j});
      to_vert.push_back(verts(tet)[j]);
      to_neighbor.push_back(behind.valid() ? behind.of_tet(to_new[behind.tet()]) : FaceCode());
    }
  }
  mesh.to_vert = std::move(to_vert), mesh.to_neighbor = std::move(to_neighbor);
  permute(mesh.to_region, sources), permute(mesh.to_fixed, sources), permute(to_quality, sources);
  editor_.forget_dead();
  slot_ = {};
  for (std::uint32_t tet = 0; tet < mesh.size(); ++tet)
    for (std::size_t j = 0; j < 4; ++j) vert_to_tet[verts(tet)[j]] = tet;
}

GrowingArray<std::uint32_t> CavityMesh::renumber(bool along_curve) {
  GrowingArray<std::uint32_t> sources = find_verts(along_curve);
  permute_verts(sources.span());
  const GrowingArray<std::uint32_t> tets = find_tets(along_curve);
  permute_tets(tets.span());
  return sources;
}

}  // namespace tetloom::adapt

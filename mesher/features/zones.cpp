#include "mesher/features/zones.hpp"

#include <algorithm>
#include <bit>

#include "core/base/disjoint_sets.hpp"
#include "core/base/mix_bits.hpp"

namespace tetloom::features {
namespace {

// Levels of points: 1 at a small triangle, one more with each edge away from it.
constexpr std::uint8_t kLastFree = 3, kLastComplete = 4, kOutermost = 5;

std::vector<std::uint8_t> find_levels(const Mesh& mesh, std::span<const std::uint32_t> small) {
  std::vector<std::uint8_t> levels(mesh.points.size(), 0);
  for (const std::uint32_t t : small)
    for (const std::uint32_t v : mesh.tri_to_vert[t]) levels[v] = 1;
  for (std::uint8_t level = 2; level <= kOutermost; ++level)
    for (const auto& verts : mesh.tri_to_vert)
      if (std::ranges::any_of(verts, [&](std::uint32_t v) { return levels[v] == level - 1; }))
        for (const std::uint32_t v : verts)
          if (levels[v] == 0) levels[v] = level;
  return levels;
}

bool is_complete(std::uint8_t level) { return level != 0 && level <= kLastComplete; }

void put_points(const Mesh& mesh, const std::vector<std::uint8_t>& levels, Zones& zones) {
  DisjointSets sets(mesh.points.size());
  for (const auto& [a, b, c] : mesh.tri_to_vert) {
    if (!is_complete(levels[a]) && !is_complete(levels[b]) && !is_complete(levels[c])) continue;
    sets.join(a, b);
    sets.join(b, c);
  }
  zones.point_to_zone.assign(mesh.points.size(), kNone);
  zones.point_in_zone.assign(mesh.points.size(), kNone);
  for (std::uint32_t v = 0; v < levels.size(); ++v) {
    if (levels[v] == 0) continue;
    const std::uint32_t lowest = sets.find(v);
    if (lowest == v) {
      zones.point_to_zone[v] = static_cast<std::uint32_t>(zones.items.size());
      zones.items.emplace_back();
    }
    const std::uint32_t zone = zones.point_to_zone[v] = zones.point_to_zone[lowest];
    zones.point_in_zone[v] = static_cast<std::uint32_t>(zones.items[zone].points.size());
    zones.items[zone].points.push_back(v);
  }
}

void put_triangles(const Mesh& mesh, const std::vector<std::uint8_t>& levels, Zones& zones) {
  zones.tri_to_zone.assign(mesh.tri_to_vert.size(), kNone);
  for (std::uint32_t t = 0; t < mesh.tri_to_vert.size(); ++t) {
    const auto& verts = mesh.tri_to_vert[t];
    if (std::ranges::none_of(verts, [&](std::uint32_t v) { return is_complete(levels[v]); })) continue;
    const std::uint32_t zone = zones.tri_to_zone[t] = zones.point_to_zone[verts[0]];
    zones.items[zone].triangles.push_back(t);
  }
}

// A piece that leaves its zone keeps its ends where they are.
void put_pieces(const Mesh& mesh, Zones& zones) {
  zones.piece_to_zone.assign(mesh.edge_to_vert.size(), kNone);
  for (std::uint32_t p = 0; p < mesh.edge_to_vert.size(); ++p) {
    const auto& [a, b] = mesh.edge_to_vert[p];
    const std::uint32_t zone = zones.point_to_zone[a];
    if (zone != zones.point_to_zone[b]) {
      zones.is_near_border[a] = zones.is_near_border[b] = 1;
    } else if (zone != kNone) {
      zones.piece_to_zone[p] = zone;
      zones.items[zone].pieces.push_back(p);
    }
  }
}

}  // namespace

Zones find_zones(const Mesh& mesh, std::span<const std::uint32_t> small) {
  const std::vector<std::uint8_t> levels = find_levels(mesh, small);
  Zones zones;
  put_points(mesh, levels, zones);
  zones.is_near_border.resize(levels.size());
  for (std::size_t v = 0; v < levels.size(); ++v) zones.is_near_border[v] = levels[v] > kLastFree;
  put_triangles(mesh, levels, zones);
  put_pieces(mesh, zones);
  return zones;
}

SurfaceItems take_items(const Mesh& mesh, const ZoneItems& numbers, std::span<const std::uint32_t> point_in_zone) {
  SurfaceItems items;
  for (const std::uint32_t v : numbers.points) {
    items.points.push_back(mesh.points[v]);
    items.point_to_entity.push_back(mesh.point_to_entity[v]);
  }
  for (const std::uint32_t t : numbers.triangles) {
    const auto& [a, b, c] = mesh.tri_to_vert[t];
    items.triangles.push_back({point_in_zone[a], point_in_zone[b], point_in_zone[c]});
    items.tri_to_face.push_back(mesh.tri_to_entity[t]);
  }
  for (const std::uint32_t p : numbers.pieces) {
    const auto& [a, b] = mesh.edge_to_vert[p];
    items.pieces.push_back({point_in_zone[a], point_in_zone[b]});
    items.piece_to_edge.push_back(mesh.edge_to_entity[p]);
  }
  return items;
}

std::uint64_t hash(const Zone& zone) {
  std::uint64_t state = zone.items.triangles.size();
  const auto add = [&](std::uint64_t value) { state = mix_bits((state ^ value) + 0x9e3779b97f4a7c15u); };
  for (const Vec3& x : zone.items.points)
    for (const double value : {x.x, x.y, x.z}) add(std::bit_cast<std::uint64_t>(value));
  for (const double tolerance : zone.tolerances) add(std::bit_cast<std::uint64_t>(tolerance));
  for (const double size : zone.sizes) add(std::bit_cast<std::uint64_t>(size));
  for (const std::uint8_t is_locked : zone.is_locked) add(is_locked);
  return state;
}

}  // namespace tetloom::features

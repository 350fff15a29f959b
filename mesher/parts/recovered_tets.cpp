#include "mesher/parts/recovered_tets.hpp"

#include <algorithm>
#include <bit>

#include "core/base/disjoint_sets.hpp"
#include "core/base/lists.hpp"
#include "mesher/parts/strip.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;

// The tets with who is to have them, ascending.
std::vector<std::pair<PartId, std::uint32_t>> tets_by_owner(const SharedInput& input, const RecoveredTets& recovered) {
  const auto count = static_cast<std::uint32_t>(recovered.made.size());
  DisjointSets sets(count);  // of tets that go together
  std::vector<std::uint32_t> tet_at(recovered.new_points.size(), kNone);
  for (std::uint32_t t = 0; t < count; ++t) {
    for (const VertKey key : recovered.made[t]) {
      if (key < kNewPoint) continue;
      std::uint32_t& first = tet_at[key - kNewPoint];
      if (first == kNone) first = t;
      sets.join(t, first);
    }
  }
  std::vector<VertKey> lowest(count, kNewPoint);  // of a set, by the tet that names it
  for (std::uint32_t t = 0; t < count; ++t)
    for (const VertKey key : recovered.made[t]) lowest[sets.find(t)] = std::min(lowest[sets.find(t)], key);
  std::vector<std::pair<PartId, std::uint32_t>> tets;
  for (std::uint32_t t = 0; t < count; ++t) {
    const VertKey key = lowest[sets.find(t)];
    tets.emplace_back(is_of_surface(key) ? input.surface.owner_of(static_cast<std::uint32_t>(key)) : maker_of(key), t);
  }
  std::sort(tets.begin(), tets.end());
  return tets;
}

// Adds the tet, with its new points as in `recovered` still.
void add_tet(const RecoveredTets& recovered, std::uint32_t tet, RecoveredTets& piece) {
  piece.made.push_back(recovered.made[tet]);
  piece.fixed.push_back(recovered.fixed[tet]);
  piece.keys.insert(piece.keys.end(), recovered.made[tet].begin(), recovered.made[tet].end());
}

// Numbers the new points of a piece and finds the places of all.
void finish_piece(const RecoveredTets& recovered, RecoveredTets& piece) {
  std::vector<VertKey>& keys = piece.keys;
  sort_unique(keys);
  const auto first_new = std::lower_bound(keys.begin(), keys.end(), kNewPoint);
  for (auto key = keys.begin(); key != first_new; ++key) {
    const auto at = std::lower_bound(recovered.keys.begin(), recovered.keys.end(), *key);
    piece.points.push_back(recovered.points[static_cast<std::size_t>(at - recovered.keys.begin())]);
  }
  for (auto key = first_new; key != keys.end(); ++key)
    piece.new_points.push_back(recovered.new_points[*key - kNewPoint]);
  for (auto& made : piece.made)
    for (VertKey& key : made)
      if (key >= kNewPoint)
        key = kNewPoint + static_cast<VertKey>(std::lower_bound(first_new, keys.end(), key) - first_new);
  keys.erase(first_new, keys.end());
}

}  // namespace

std::vector<std::pair<PartId, RecoveredTets>> deal_recovered(const SharedInput& input, const RecoveredTets& recovered) {
  std::vector<std::pair<PartId, RecoveredTets>> dealt;
  for (const auto& [part, tet] : tets_by_owner(input, recovered)) {
    if (dealt.empty() || dealt.back().first != part) dealt.emplace_back(part, RecoveredTets());
    add_tet(recovered, tet, dealt.back().second);
  }
  for (auto& [part, piece] : dealt) finish_piece(recovered, piece);
  return dealt;
}

void put(MessageWriter& writer, const RecoveredTets& recovered) {
  writer.put_array(std::span<const std::array<VertKey, 4>>(recovered.made));
  writer.put_array(std::span<const std::uint8_t>(recovered.fixed));
  writer.put_array(std::span<const VertKey>(recovered.keys));
  writer.put_array(std::span<const Vec3>(recovered.points));
  writer.put_array(std::span<const Vec3>(recovered.new_points));
}

RecoveredTets get_recovered(MessageReader& reader) {
  RecoveredTets recovered;
  recovered.made = reader.get_array<std::array<VertKey, 4>>();
  recovered.fixed = reader.get_array<std::uint8_t>();
  recovered.keys = reader.get_array<VertKey>();
  recovered.points = reader.get_array<Vec3>();
  recovered.new_points = reader.get_array<Vec3>();
  return recovered;
}

std::size_t add_recovered(PartTets& tets, PartId part, const RecoveredTets& recovered, std::uint32_t region) {
  KeyedTets strip;
  std::size_t sides = 0;
  for (std::size_t v = 0; v < recovered.keys.size(); ++v) {
    strip.keys.push_back(recovered.keys[v]);
    strip.mesh.points.push_back(recovered.points[v]);
    strip.waits.push_back(0);
  }
  for (const Vec3& point : recovered.new_points) strip.mesh.points.push_back(point);
  for (std::size_t t = 0; t < recovered.made.size(); ++t) {
    for (const VertKey key : recovered.made[t]) {
      const auto at = std::lower_bound(recovered.keys.begin(), recovered.keys.end(), key);
      strip.mesh.to_vert.push_back(key >= kNewPoint
                                       ? static_cast<std::uint32_t>(recovered.keys.size() + (key - kNewPoint))
                                       : static_cast<std::uint32_t>(at - recovered.keys.begin()));
    }
    strip.mesh.to_region.push_back(region);
    strip.mesh.to_fixed.push_back(recovered.fixed[t]);
    sides += static_cast<std::size_t>(std::popcount(recovered.fixed[t]));
  }
  link_strip(strip);
  std::vector<FaceCode> open;
  for (const FaceCode face : tets.mesh.faces())
    if (!tets.mesh.behind(face).valid() && !tets.mesh.is_fixed(face)) open.push_back(face);
  put_in(tets, part, std::move(strip), open);
  return sides;
}

}  // namespace tetloom::parts

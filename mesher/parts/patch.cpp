#include "mesher/parts/patch.hpp"

#include <algorithm>
#include <bit>

#include "core/base/disjoint_sets.hpp"
#include "mesher/parts/strip.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;

// The tets of a patch with who is to have them, ascending.
std::vector<std::pair<PartId, std::uint32_t>> tets_by_owner(const SharedInput& input, const PatchTets& patch) {
  const auto count = static_cast<std::uint32_t>(patch.made.size());
  DisjointSets sets(count);  // of tets that go together
  std::vector<std::uint32_t> tet_at(patch.new_points.size(), kNone);
  for (std::uint32_t t = 0; t < count; ++t) {
    for (const VertKey key : patch.made[t]) {
      if (key < kNewPoint) continue;
      std::uint32_t& first = tet_at[key - kNewPoint];
      if (first == kNone) first = t;
      sets.join(t, first);
    }
  }
  std::vector<VertKey> lowest(count, kNewPoint);  // of a set, by the tet that names it
  for (std::uint32_t t = 0; t < count; ++t)
    for (const VertKey key : patch.made[t]) lowest[sets.find(t)] = std::min(lowest[sets.find(t)], key);
  std::vector<std::pair<PartId, std::uint32_t>> tets;
  for (std::uint32_t t = 0; t < count; ++t) {
    const VertKey key = lowest[sets.find(t)];
    tets.emplace_back(is_of_surface(key) ? input.surface.owner_of(static_cast<std::uint32_t>(key)) : maker_of(key), t);
  }
  std::sort(tets.begin(), tets.end());
  return tets;
}

// Adds the tet, with its new points as in `patch` still.
void add_tet(const PatchTets& patch, std::uint32_t tet, PatchTets& piece) {
  piece.made.push_back(patch.made[tet]);
  piece.fixed.push_back(patch.fixed[tet]);
  piece.keys.insert(piece.keys.end(), patch.made[tet].begin(), patch.made[tet].end());
}

// Numbers the new points of a piece and finds the places of all.
void finish_piece(const PatchTets& patch, PatchTets& piece) {
  std::vector<VertKey>& keys = piece.keys;
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  const auto first_new = std::lower_bound(keys.begin(), keys.end(), kNewPoint);
  for (auto key = keys.begin(); key != first_new; ++key) {
    const auto at = std::lower_bound(patch.keys.begin(), patch.keys.end(), *key);
    piece.points.push_back(patch.points[static_cast<std::size_t>(at - patch.keys.begin())]);
  }
  for (auto key = first_new; key != keys.end(); ++key) piece.new_points.push_back(patch.new_points[*key - kNewPoint]);
  for (auto& made : piece.made)
    for (VertKey& key : made)
      if (key >= kNewPoint)
        key = kNewPoint + static_cast<VertKey>(std::lower_bound(first_new, keys.end(), key) - first_new);
  keys.erase(first_new, keys.end());
}

}  // namespace

std::vector<std::pair<PartId, PatchTets>> deal_patch(const SharedInput& input, const PatchTets& patch) {
  std::vector<std::pair<PartId, PatchTets>> dealt;
  for (const auto& [part, tet] : tets_by_owner(input, patch)) {
    if (dealt.empty() || dealt.back().first != part) dealt.emplace_back(part, PatchTets());
    add_tet(patch, tet, dealt.back().second);
  }
  for (auto& [part, piece] : dealt) finish_piece(patch, piece);
  return dealt;
}

void put(MessageWriter& writer, const PatchTets& patch) {
  writer.put_array(std::span<const std::array<VertKey, 4>>(patch.made));
  writer.put_array(std::span<const std::uint8_t>(patch.fixed));
  writer.put_array(std::span<const VertKey>(patch.keys));
  writer.put_array(std::span<const Vec3>(patch.points));
  writer.put_array(std::span<const Vec3>(patch.new_points));
}

PatchTets get_patch(MessageReader& reader) {
  PatchTets patch;
  patch.made = reader.get_array<std::array<VertKey, 4>>();
  patch.fixed = reader.get_array<std::uint8_t>();
  patch.keys = reader.get_array<VertKey>();
  patch.points = reader.get_array<Vec3>();
  patch.new_points = reader.get_array<Vec3>();
  return patch;
}

void put_in_patch(PartState& state, PartId part, const PatchTets& patch, std::uint32_t region) {
  Strip strip;
  for (std::size_t v = 0; v < patch.keys.size(); ++v) {
    strip.keys.push_back(patch.keys[v]);
    strip.mesh.points.push_back(patch.points[v]);
    strip.waits.push_back(0);
  }
  for (const Vec3& point : patch.new_points) strip.mesh.points.push_back(point);
  for (std::size_t t = 0; t < patch.made.size(); ++t) {
    for (const VertKey key : patch.made[t]) {
      const auto at = std::lower_bound(patch.keys.begin(), patch.keys.end(), key);
      strip.mesh.to_vert.push_back(key >= kNewPoint ? static_cast<std::uint32_t>(patch.keys.size() + (key - kNewPoint))
                                                    : static_cast<std::uint32_t>(at - patch.keys.begin()));
    }
    strip.mesh.to_region.push_back(region);
    strip.mesh.to_fixed.push_back(patch.fixed[t]);
    state.seen_sides += static_cast<std::size_t>(std::popcount(patch.fixed[t]));
  }
  state.figures.shell_tets += patch.made.size();
  link_strip(strip);
  std::vector<FaceCode> open;
  for (FaceCode face = 0; face < state.mesh.to_neighbor.size(); ++face)
    if (state.mesh.to_neighbor[face] == kNone && !state.mesh.is_fixed(face)) open.push_back(face);
  put_in(state, part, std::move(strip), open);
}

}  // namespace tetloom::parts

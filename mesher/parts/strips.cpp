#include "mesher/parts/strips.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/stopwatch.hpp"
#include "mesher/parts/borders.hpp"
#include "mesher/parts/optimize_part.hpp"
#include "mesher/parts/send_found.hpp"
#include "mesher/parts/strip.hpp"
#include "mesher/tets/tet_quality.hpp"
#include "mesher/tets/triangle_verts.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;
using tets::TetMesh;

constexpr float kPoor = .9f * .9f * .9f;  // cubed: what the optimiser's last pass looks at

struct SharedVert {
  VertKey key;
  std::uint64_t is_poor;
};

std::vector<FaceCode> find_open_faces(const TetMesh& mesh) {
  std::vector<FaceCode> open;
  for (FaceCode face = 0; face < mesh.to_neighbor.size(); ++face)
    if (mesh.to_neighbor[face] == kNone && !mesh.is_dead(face / 4) && !mesh.is_fixed(face)) open.push_back(face);
  return open;
}

// Of every vertex, the farthest reach.
void keep_farthest(std::vector<std::pair<std::uint32_t, double>>& verts) {
  std::sort(verts.begin(), verts.end(),
            [](const auto& s, const auto& t) { return s.first != t.first ? s.first < t.first : s.second > t.second; });
  verts.erase(std::unique(verts.begin(), verts.end(), [](const auto& s, const auto& t) { return s.first == t.first; }),
              verts.end());
}

// Vertices that wait at poor tets that have an open face or lie next to one; with how far neighbours are looked for.
std::vector<std::pair<std::uint32_t, double>> find_poor(const PartState& state) {
  const TetMesh& mesh = state.mesh;
  std::vector<std::pair<std::uint32_t, double>> poor;
  const auto look_at = [&](std::uint32_t tet, FaceCode open) {
    if (state.qualities[tet] >= kPoor) return;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t v = mesh.to_vert[std::size_t{tet} * 4 + i];
      if (state.waits[v]) poor.emplace_back(v, reach_of(mesh, open));
    }
  };
  for (const FaceCode open : state.open_faces) {
    const std::uint32_t tet = open / 4;
    look_at(tet, open);
    for (FaceCode face = tet * 4; face < tet * 4 + 4; ++face)
      if (mesh.to_neighbor[face] != kNone) look_at(mesh.to_neighbor[face] / 4, open);
  }
  keep_farthest(poor);
  return poor;
}

// Vertices of open faces so far outside of the part's box that others do not look for the part there: a patch may reach
// that far. In the same form.
std::vector<std::pair<std::uint32_t, double>> find_astray(const PartState& state, const Box3& own_box) {
  const TetMesh& mesh = state.mesh;
  std::vector<std::pair<std::uint32_t, double>> astray;
  for (const FaceCode open : state.open_faces) {
    for (const std::uint32_t v : verts_of(mesh, open)) {
      const double outside = state.waits[v] ? distance_outside(mesh.points[v], own_box) : 0;
      if (outside <= 0) continue;
      if (const double reach = reach_of(mesh, open); outside > reach) astray.emplace_back(v, reach);
    }
  }
  keep_farthest(astray);
  return astray;
}

std::vector<VertKey> keys_of(const PartState& state, std::span<const std::pair<std::uint32_t, double>> verts) {
  std::vector<VertKey> keys;
  for (const auto& [v, reach] : verts) keys.push_back(state.keys[v]);
  std::sort(keys.begin(), keys.end());
  return keys;
}

// The tets of a part within two layers around some of its vertices, each for the part that claims it.
class Extraction {
 public:
  explicit Extraction(const PartState& state)
      : state_(state),
        mesh_(state.mesh),
        tet_to_claim_(state.mesh.size()),
        corner_is_walked_(state.mesh.size(), 0),
        vert_is_shared_(state.mesh.points.size(), 0),
        vert_is_done_(state.mesh.points.size(), 0) {
    for (const FaceCode face : state.open_faces)
      for (const std::uint32_t v : verts_of(mesh_, face)) vert_is_shared_[v] = 1;
  }

  /// `claims`: vertices with who claims them, ascending by claimant.
  std::vector<std::pair<PartId, std::vector<std::uint32_t>>> run(
      std::span<const std::pair<PartId, std::uint32_t>> claims) {
    std::vector<PartId> vert_to_claim(mesh_.points.size());
    for (const auto& [part, vert] : claims) vert_to_claim[vert] = part;
    // Where a star is in several pieces, each has an open face at its vertex.
    std::vector<std::pair<PartId, FaceCode>> seeds;
    for (const FaceCode face : state_.open_faces)
      for (const std::uint32_t v : verts_of(mesh_, face))
        if (vert_to_claim[v].valid()) seeds.emplace_back(vert_to_claim[v], face / 4 * 4 + corner_of(face / 4, v));
    std::stable_sort(seeds.begin(), seeds.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [part, code] : seeds) claim_star(code, part);
    const std::vector<std::uint32_t> first_layer = claimed_;
    for (const std::uint32_t tet : first_layer)
      for (std::uint32_t corner = 0; corner < 4; ++corner) claim_star(tet * 4 + corner, tet_to_claim_[tet]);
    std::vector<std::pair<PartId, std::vector<std::uint32_t>>> result;
    std::stable_sort(claimed_.begin(), claimed_.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return tet_to_claim_[a] < tet_to_claim_[b]; });
    for (const std::uint32_t tet : claimed_) {
      if (result.empty() || result.back().first != tet_to_claim_[tet]) result.push_back({tet_to_claim_[tet], {}});
      result.back().second.push_back(tet);
    }
    for (auto& [part, tets] : result) std::sort(tets.begin(), tets.end());
    return result;
  }

 private:
  std::uint32_t corner_of(std::uint32_t tet, std::uint32_t vert) const {
    const std::uint32_t* v = &mesh_.to_vert[std::size_t{tet} * 4];
    return v[0] == vert ? 0 : v[1] == vert ? 1 : v[2] == vert ? 2 : 3;
  }

  // Tets around the vertex at a corner, as far as they hang together, that nobody claims yet. Stars are not cut where
  // others have claimed a part of them.
  void claim_star(FaceCode code, PartId part) {
    const std::uint32_t vert = mesh_.to_vert[code];
    // Stars that are no part's border hang together: one walk is enough.
    if (vert_is_shared_[vert] ? is_walked(code) : std::exchange(vert_is_done_[vert], 1) != 0) return;
    stack_.assign(1, code / 4);
    walk(code);
    while (!stack_.empty()) {
      const std::uint32_t tet = stack_.back();
      stack_.pop_back();
      if (!tet_to_claim_[tet].valid()) {
        tet_to_claim_[tet] = part;
        claimed_.push_back(tet);
      }
      const std::uint32_t corner = corner_of(tet, vert);
      for (std::uint32_t i = 0; i < 4; ++i) {
        const FaceCode face = tet * 4 + i, behind = mesh_.to_neighbor[face];
        if (i == corner || behind == kNone || mesh_.is_fixed(face)) continue;
        const FaceCode next = behind / 4 * 4 + corner_of(behind / 4, vert);
        if (is_walked(next)) continue;
        walk(next);
        stack_.push_back(behind / 4);
      }
    }
  }

  // Whether the star of the vertex at this corner was walked through the tet.
  bool is_walked(FaceCode code) const { return (corner_is_walked_[code / 4] >> code % 4 & 1) != 0; }
  void walk(FaceCode code) { corner_is_walked_[code / 4] |= static_cast<std::uint8_t>(1u << code % 4); }

  const PartState& state_;
  const TetMesh& mesh_;
  std::vector<PartId> tet_to_claim_;
  std::vector<std::uint8_t> corner_is_walked_;  // a bit per corner of a tet
  std::vector<std::uint32_t> claimed_, stack_;
  std::vector<char> vert_is_shared_, vert_is_done_;
};

struct Heard {
  PartId from;
  std::span<const SharedVert> verts;
};

}  // namespace

void send_poor(const SharedInput& input, PartState& state, PartTask& task) {
  TetMesh& mesh = state.mesh;
  state.waits.resize(mesh.points.size(), 0);
  if (!std::exchange(state.knows_waits, true)) {
    state.open_faces = find_open_faces(mesh);
    for (const FaceCode face : state.open_faces)
      for (const std::uint32_t v : verts_of(mesh, face)) state.waits[v] = 1;
  }
  std::vector<std::pair<std::uint32_t, double>> told = find_poor(state);
  state.poor = keys_of(state, told);
  const auto astray = find_astray(state, input.decomposition.box(task.part()));
  state.astray = keys_of(state, astray);
  told.insert(told.end(), astray.begin(), astray.end());
  keep_farthest(told);
  send_found<VertKey>(input, task, [&](PartId, const Box3& box, std::vector<VertKey>& near) {
    for (const auto& [v, reach] : told)
      if (distance_outside(mesh.points[v], box) <= reach) near.push_back(state.keys[v]);
  });
}

void send_shared(const SharedInput& input, PartState& state, PartTask& task) {
  std::vector<VertKey> wanted = state.poor;
  wanted.insert(wanted.end(), state.astray.begin(), state.astray.end());
  std::vector<std::pair<VertKey, PartId>> told;
  for (const Message& message : task.inbox()) {
    for (const VertKey key : MessageReader(message.bytes).get_view<VertKey>()) {
      wanted.push_back(key);
      told.emplace_back(key, message.from);
    }
  }
  std::sort(wanted.begin(), wanted.end());
  std::sort(told.begin(), told.end());
  state.shared.clear();
  if (wanted.empty()) return;
  const TetMesh& mesh = state.mesh;
  std::vector<char> seen(mesh.points.size(), 0);
  std::vector<std::pair<PartState::SharedVert, double>> shared;
  for (const FaceCode face : state.open_faces) {
    for (const std::uint32_t v : verts_of(mesh, face)) {
      if (std::exchange(seen[v], 1)) continue;
      const VertKey key = state.keys[v];
      if (!std::binary_search(wanted.begin(), wanted.end(), key)) continue;
      const bool is_poor = std::binary_search(state.poor.begin(), state.poor.end(), key);
      shared.push_back({{key, v, is_poor}, reach_of(mesh, face)});
    }
  }
  std::sort(shared.begin(), shared.end(), [](const auto& s, const auto& t) { return s.first.key < t.first.key; });
  for (const auto& [vert, reach] : shared) state.shared.push_back(vert);
  send_found<SharedVert>(input, task, [&](PartId other, const Box3& box, std::vector<SharedVert>& near) {
    for (const auto& [vert, reach] : shared)
      if (distance_outside(mesh.points[vert.vert], box) <= reach ||
          std::binary_search(told.begin(), told.end(), std::pair{vert.key, other}))
        near.push_back({vert.key, std::uint64_t{vert.is_poor}});
  });
}

void send_strips(PartState& state, std::size_t round, PartTask& task) {
  std::vector<Heard> heard;
  for (const Message& message : task.inbox())
    heard.push_back({message.from, MessageReader(message.bytes).get_view<SharedVert>()});
  std::vector<std::pair<PartId, std::uint32_t>> claims;
  std::vector<std::size_t> next(heard.size(), 0);
  for (const auto& vert : state.shared) {
    PartId lowest = task.part();
    std::size_t sharers = 0;
    bool poor = vert.is_poor;
    state.figures.parts.strips[round].waiting += vert.is_poor;
    for (std::size_t i = 0; i < heard.size(); ++i) {
      const auto& list = heard[i].verts;
      while (next[i] < list.size() && list[next[i]].key < vert.key) ++next[i];
      if (next[i] == list.size() || list[next[i]].key != vert.key) continue;
      ++sharers;
      poor |= list[next[i]].is_poor != 0;
      lowest = std::min(lowest, heard[i].from);
    }
    if (!poor || sharers == 0 || (round == 0 && sharers > 1)) continue;
    claims.emplace_back(lowest, vert.vert);
  }
  state.own_piece.clear();
  state.opened.clear();
  if (claims.empty()) return;
  std::sort(claims.begin(), claims.end());
  TetPacker packer(state);
  for (const auto& [part, tets] : Extraction(state).run(claims)) {
    Bytes bytes = packer.pack(tets);
    take_out(state, tets, state.opened);
    state.figures.parts.strips[round].tets += tets.size();
    state.figures.parts.strips[round].moved += part == task.part() ? 0 : tets.size();
    if (part == task.part()) {
      state.own_piece = std::move(bytes);
    } else {
      task.send(part, std::move(bytes));
    }
  }
}

void take_strips(const SharedInput& input, PartState& state, PartTask& task) {
  Stopwatch watch;
  std::vector<Bytes> pieces;
  for (Message& message : task.inbox()) {
    if (!state.own_piece.empty() && message.from > task.part()) pieces.push_back(std::exchange(state.own_piece, {}));
    pieces.push_back(std::move(message.bytes));
  }
  if (!state.own_piece.empty()) pieces.push_back(std::exchange(state.own_piece, {}));
  std::erase_if(state.open_faces, [&](FaceCode face) { return state.mesh.is_dead(face / 4); });
  for (const FaceCode face : state.opened)
    if (!state.mesh.is_dead(face / 4)) state.open_faces.push_back(face);
  if (!pieces.empty()) {
    Strip strip = unpack_strip(pieces);
    optimize_strip(input, strip, state, task.runner());
    put_in(state, task.part(), std::move(strip), state.open_faces);
  }
  // Faces of the surface that taking out has opened are open for what comes back only.
  std::erase_if(state.open_faces, [&](FaceCode face) { return state.mesh.is_fixed(face); });
  state.opened.clear();
  state.figures.seconds.optimize += watch.lap();
}

}  // namespace tetloom::parts

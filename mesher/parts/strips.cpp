#include "mesher/parts/strips.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/lists.hpp"
#include "core/base/stopwatch.hpp"
#include "mesher/parts/borders.hpp"
#include "mesher/parts/extraction.hpp"
#include "mesher/parts/key_filter.hpp"
#include "mesher/parts/near_box.hpp"
#include "mesher/parts/optimize_part.hpp"
#include "tetloom/tasks.hpp"

#include "core/tets/many_values.hpp"
#include "core/tets/tet_quality.hpp"
#include "core/tets/triangle_verts.hpp"
#include "mesher/parts/strip.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;
using tets::TetMesh;

constexpr float kPoor = .9f * .9f * .9f;  // cubed: what the optimiser's last pass looks at

struct SharedVertNote {
  VertKey key;
  std::uint64_t is_poor;
};

std::vector<FaceCode> find_open_faces(const TetMesh& mesh) {
  std::vector<FaceCode> open;
  const std::span<const FaceCode> behind = mesh.to_neighbor;
  tets::for_each_that(
      0, behind.size(), [=](std::size_t face) { return !behind[face].valid(); },
      [&](std::size_t at) {
        const FaceCode face = FaceCode::at(at);
        if (!mesh.is_dead(face.tet()) && !mesh.is_fixed(face)) open.push_back(face);
      });
  return open;
}

// The vertices of open faces.
std::vector<BorderVert> find_border(const PartState& state) {
  std::vector<BorderVert> border;
  std::vector<char> seen(state.mesh.points.size(), 0);
  for (const FaceCode face : state.strips.open_faces)
    for (const std::uint32_t v : verts_of(state.mesh, face))
      if (!std::exchange(seen[v], 1)) border.push_back({v, face});
  return border;
}

// Of every vertex, the farthest reach.
void keep_farthest(std::vector<ToldVert>& verts) {
  std::sort(verts.begin(), verts.end(), [](const ToldVert& s, const ToldVert& t) {
    return s.vert != t.vert ? s.vert < t.vert : s.reach > t.reach;
  });
  const auto end =
      std::unique(verts.begin(), verts.end(), [](const ToldVert& s, const ToldVert& t) { return s.vert == t.vert; });
  verts.erase(end, verts.end());
}

// Vertices that wait at poor tets that have an open face or lie next to one; with how far neighbours are looked for.
std::vector<ToldVert> find_poor(const PartState& state) {
  const TetMesh& mesh = state.mesh;
  std::vector<ToldVert> poor;
  const auto look_at = [&](std::uint32_t tet, FaceCode open) {
    if (state.qualities[tet] >= kPoor) return;
    const double reach = reach_of(mesh, open);
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t v = mesh.to_vert[std::size_t{tet} * 4 + i];
      if (state.waits[v]) poor.push_back({v, reach});
    }
  };
  for (const FaceCode open : state.strips.open_faces) {
    const std::uint32_t tet = open.tet();
    look_at(tet, open);
    for (const FaceCode face : FaceCode::of(tet))
      if (mesh.behind(face).valid()) look_at(mesh.behind(face).tet(), open);
  }
  keep_farthest(poor);
  return poor;
}

// Whether any vertex lies so far outside of the box as others do not look for the part at any open face.
bool may_be_astray(const PartState& state, std::span<const BorderVert> border, const Box3& own_box) {
  double outside = 0, least = HUGE_VAL;
  for (const auto& [v, face] : border)
    if (state.waits[v]) outside = std::max(outside, distance_outside(state.mesh.points[v], own_box));
  if (outside <= 0) return false;
  for (const FaceCode open : state.strips.open_faces) least = std::min(least, least_reach_of(state.mesh, open));
  return outside > least;
}

// Vertices of open faces so far outside of the part's box that others do not look for the part there: a patch may reach
// that far. In the same form.
std::vector<ToldVert> find_astray(const PartState& state, std::span<const BorderVert> border, const Box3& own_box) {
  const TetMesh& mesh = state.mesh;
  std::vector<ToldVert> astray;
  if (!may_be_astray(state, border, own_box)) return astray;
  for (const FaceCode open : state.strips.open_faces) {
    for (const std::uint32_t v : verts_of(mesh, open)) {
      const double outside = state.waits[v] ? distance_outside(mesh.points[v], own_box) : 0;
      if (outside <= 0) continue;
      if (const double reach = reach_of(mesh, open); outside > reach) astray.push_back({v, reach});
    }
  }
  keep_farthest(astray);
  return astray;
}

std::vector<VertKey> keys_of(const PartState& state, std::span<const ToldVert> verts) {
  std::vector<VertKey> keys;
  for (const ToldVert& told : verts) keys.push_back(state.keys[told.vert]);
  std::sort(keys.begin(), keys.end());
  return keys;
}

PartBorder look_at_border(const PartState& state, const Box3& own_box) {
  PartBorder border;
  border.verts = find_border(state);
  border.told = find_poor(state);
  border.poor = keys_of(state, border.told);
  const std::vector<ToldVert> astray = find_astray(state, border.verts, own_box);
  border.astray = keys_of(state, astray);
  border.told.insert(border.told.end(), astray.begin(), astray.end());
  keep_farthest(border.told);
  return border;
}

// What each neighbour is told, if anything.
template <class T>
void send_lists(const SharedInput& input, PartTask& task, const std::vector<std::vector<T>>& lists) {
  const auto neighbors = input.decomposition.neighbors(task.part());
  for (std::size_t n = 0; n < lists.size(); ++n) {
    if (lists[n].empty()) continue;
    MessageWriter writer;
    writer.put_array<T>(lists[n]);
    task.send(neighbors[n], writer.take());
  }
}

// Who has told of each vertex, ascending.
using Tellers = std::vector<std::pair<VertKey, PartId>>;

// Those of the border whose keys are wanted, ascending, with their reaches.
std::vector<std::pair<SharedVert, double>> find_shared(const PartState& state, std::span<const VertKey> wanted) {
  const KeyFilter filter(wanted);
  std::vector<std::pair<SharedVert, double>> shared;
  for (const auto& [v, face] : state.strips.border.verts) {
    const VertKey key = state.keys[v];
    if (!filter.may_hold(key) || !std::binary_search(wanted.begin(), wanted.end(), key)) continue;
    const bool is_poor = std::binary_search(state.strips.border.poor.begin(), state.strips.border.poor.end(), key);
    shared.push_back({{key, v, is_poor}, reach_of(state.mesh, face)});
  }
  std::sort(shared.begin(), shared.end(), [](const auto& s, const auto& t) { return s.first.key < t.first.key; });
  return shared;
}

struct Heard {
  PartId from;
  std::span<const SharedVertNote> verts;
};

}  // namespace

void send_poor(const SharedInput& input, PartState& state, PartTask& task) {
  TetMesh& mesh = state.mesh;
  state.waits.resize(mesh.points.size(), 0);
  if (!std::exchange(state.strips.knows_waits, true)) {
    state.strips.open_faces = find_open_faces(mesh);
    for (const FaceCode face : state.strips.open_faces)
      for (const std::uint32_t v : verts_of(mesh, face)) state.waits[v] = 1;
  }
  // After a round, open faces are often as they were.
  if (std::exchange(state.strips.open_faces_changed, false))
    state.strips.border = look_at_border(state, input.decomposition.box(task.part()));
  std::vector<Placed<VertKey>> told;
  for (const auto& [v, reach] : state.strips.border.told) told.push_back({mesh.points[v], reach, state.keys[v]});
  send_lists(input, task, near_neighbors(told, input.decomposition, task.part()));
}

void send_shared(const SharedInput& input, PartState& state, PartTask& task) {
  std::vector<VertKey> wanted = state.strips.border.poor;
  wanted.insert(wanted.end(), state.strips.border.astray.begin(), state.strips.border.astray.end());
  Tellers tellers;
  for (const Message& message : task.inbox()) {
    for (const VertKey key : MessageReader(message.bytes).get_view<VertKey>()) {
      wanted.push_back(key);
      tellers.emplace_back(key, message.from);
    }
  }
  std::sort(wanted.begin(), wanted.end());
  sort_unique(tellers);
  state.strips.shared.clear();
  if (wanted.empty()) return;
  const NeighborBoxes boxes(input.decomposition, task.part());
  const auto neighbors = input.decomposition.neighbors(task.part());
  std::vector<std::vector<SharedVertNote>> lists(boxes.size());
  auto teller = tellers.begin();
  for (const auto& [vert, reach] : find_shared(state, wanted)) {
    state.strips.shared.push_back(vert);
    const SharedVertNote told{vert.key, std::uint64_t{vert.is_poor}};
    const Vec3& x = state.mesh.points[vert.vert];
    boxes.for_each_near(x, reach, [&](std::size_t n) { lists[n].push_back(told); });
    while (teller != tellers.end() && teller->first < vert.key) ++teller;
    for (; teller != tellers.end() && teller->first == vert.key; ++teller) {
      if (is_within(x, input.decomposition.box(teller->second), reach)) continue;
      const auto at = std::lower_bound(neighbors.begin(), neighbors.end(), teller->second);
      lists[static_cast<std::size_t>(at - neighbors.begin())].push_back(told);
    }
  }
  send_lists(input, task, lists);
}

void send_strips(PartState& state, std::size_t round, PartTask& task) {
  std::vector<Heard> heard;
  for (const Message& message : task.inbox())
    heard.push_back({message.from, MessageReader(message.bytes).get_view<SharedVertNote>()});
  std::vector<std::pair<PartId, std::uint32_t>> owned;
  std::vector<std::size_t> next(heard.size(), 0);
  for (const auto& vert : state.strips.shared) {
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
    owned.emplace_back(lowest, vert.vert);
  }
  state.strips.own_piece.clear();
  state.strips.opened.clear();
  if (owned.empty()) return;
  std::sort(owned.begin(), owned.end());
  state.strips.open_faces_changed = true;
  TetPacker packer(state.mesh);
  for (const auto& [part, tets] : find_tets_to_migrate(state, owned)) {
    Bytes bytes = pack_piece(state, tets, packer);
    take_out(state, tets, state.strips.opened);
    state.figures.parts.strips[round].tets += tets.size();
    state.figures.parts.strips[round].moved += part == task.part() ? 0 : tets.size();
    if (part == task.part()) {
      state.strips.own_piece = std::move(bytes);
    } else {
      task.send(part, std::move(bytes));
    }
  }
}

void take_strips(const SharedInput& input, PartState& state, PartTask& task) {
  Stopwatch watch;
  std::vector<Bytes> pieces;
  for (Message& message : task.inbox()) {
    if (!state.strips.own_piece.empty() && message.from > task.part())
      pieces.push_back(std::exchange(state.strips.own_piece, {}));
    pieces.push_back(std::move(message.bytes));
  }
  if (!state.strips.own_piece.empty()) pieces.push_back(std::exchange(state.strips.own_piece, {}));
  std::erase_if(state.strips.open_faces, [&](FaceCode face) { return state.mesh.is_dead(face.tet()); });
  for (const FaceCode face : state.strips.opened)
    if (!state.mesh.is_dead(face.tet())) state.strips.open_faces.push_back(face);
  if (!pieces.empty()) {
    state.strips.open_faces_changed = true;
    Strip strip = unpack_strip(std::move(pieces), task.runner());
    optimize_strip(input, strip, state, task.runner());
    put_in(state, task.part(), std::move(strip), state.strips.open_faces);
  }
  // Faces of the surface that taking out has opened are open for what comes back only.
  std::erase_if(state.strips.open_faces, [&](FaceCode face) { return state.mesh.is_fixed(face); });
  state.strips.opened.clear();
  state.figures.seconds.optimize += watch.lap();
}

}  // namespace tetloom::parts

#include "mesher/parts/strips.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/lists.hpp"
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
std::vector<BorderVert> find_border(const TetMesh& mesh, std::span<const FaceCode> open_faces) {
  std::vector<BorderVert> border;
  std::vector<char> seen(mesh.points.size(), 0);
  for (const FaceCode face : open_faces)
    for (const std::uint32_t v : verts_of(mesh, face))
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
std::vector<ToldVert> find_poor(const KeyedTets& part, std::span<const FaceCode> open_faces) {
  const TetMesh& mesh = part.mesh;
  std::vector<ToldVert> poor;
  const auto look_at = [&](std::uint32_t tet, FaceCode open) {
    if (part.qualities[tet] >= kPoor) return;
    const double reach = reach_of(mesh, open);
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t v = mesh.to_vert[std::size_t{tet} * 4 + i];
      if (part.waits[v]) poor.push_back({v, reach});
    }
  };
  for (const FaceCode open : open_faces) {
    const std::uint32_t tet = open.tet();
    look_at(tet, open);
    for (const FaceCode face : FaceCode::of(tet))
      if (mesh.behind(face).valid()) look_at(mesh.behind(face).tet(), open);
  }
  keep_farthest(poor);
  return poor;
}

// Whether any vertex lies so far outside of the box as others do not look for the part at any open face.
bool may_be_astray(const KeyedTets& part, std::span<const FaceCode> open_faces, std::span<const BorderVert> border,
                   const Box3& own_box) {
  double outside = 0, least = HUGE_VAL;
  for (const auto& [v, face] : border)
    if (part.waits[v]) outside = std::max(outside, distance_outside(part.mesh.points[v], own_box));
  if (outside <= 0) return false;
  for (const FaceCode open : open_faces) least = std::min(least, least_reach_of(part.mesh, open));
  return outside > least;
}

// Vertices of open faces so far outside of the part's box that others do not look for the part there: a patch may reach
// that far. In the same form.
std::vector<ToldVert> find_astray(const KeyedTets& part, std::span<const FaceCode> open_faces,
                                  std::span<const BorderVert> border, const Box3& own_box) {
  const TetMesh& mesh = part.mesh;
  std::vector<ToldVert> astray;
  if (!may_be_astray(part, open_faces, border, own_box)) return astray;
  for (const FaceCode open : open_faces) {
    for (const std::uint32_t v : verts_of(mesh, open)) {
      const double outside = part.waits[v] ? distance_outside(mesh.points[v], own_box) : 0;
      if (outside <= 0) continue;
      if (const double reach = reach_of(mesh, open); outside > reach) astray.push_back({v, reach});
    }
  }
  keep_farthest(astray);
  return astray;
}

std::vector<VertKey> keys_of(const KeyedTets& part, std::span<const ToldVert> verts) {
  std::vector<VertKey> keys;
  for (const ToldVert& told : verts) keys.push_back(part.keys[told.vert]);
  std::sort(keys.begin(), keys.end());
  return keys;
}

PartBorder look_at_border(const KeyedTets& part, std::span<const FaceCode> open_faces, const Box3& own_box) {
  PartBorder border;
  border.verts = find_border(part.mesh, open_faces);
  border.told = find_poor(part, open_faces);
  border.poor = keys_of(part, border.told);
  const std::vector<ToldVert> astray = find_astray(part, open_faces, border.verts, own_box);
  border.astray = keys_of(part, astray);
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
std::vector<std::pair<SharedVert, double>> find_shared(const KeyedTets& part, const PartBorder& border,
                                                       std::span<const VertKey> wanted) {
  const KeyFilter filter(wanted);
  std::vector<std::pair<SharedVert, double>> shared;
  for (const auto& [v, face] : border.verts) {
    const VertKey key = part.keys[v];
    if (!filter.may_hold(key) || !std::binary_search(wanted.begin(), wanted.end(), key)) continue;
    const bool is_poor = std::binary_search(border.poor.begin(), border.poor.end(), key);
    shared.push_back({{key, v, is_poor}, reach_of(part.mesh, face)});
  }
  std::sort(shared.begin(), shared.end(), [](const auto& s, const auto& t) { return s.first.key < t.first.key; });
  return shared;
}

struct Heard {
  PartId from;
  std::span<const SharedVertNote> verts;
};

}  // namespace

void send_poor(const SharedInput& input, PartTets& part, StripState& strips, PartTask& task) {
  TetMesh& mesh = part.mesh;
  part.waits.resize(mesh.points.size(), 0);
  if (!std::exchange(strips.knows_waits, true)) {
    strips.open_faces = find_open_faces(mesh);
    for (const FaceCode face : strips.open_faces)
      for (const std::uint32_t v : verts_of(mesh, face)) part.waits[v] = 1;
  }
  // After a round, open faces are often as they were.
  if (std::exchange(strips.open_faces_changed, false))
    strips.border = look_at_border(part, strips.open_faces, input.decomposition.box(task.part()));
  std::vector<Placed<VertKey>> told;
  for (const auto& [v, reach] : strips.border.told) told.push_back({mesh.points[v], reach, part.keys[v]});
  send_lists(input, task, near_neighbors(told, input.decomposition, task.part()));
}

void send_shared(const SharedInput& input, const PartTets& part, StripState& strips, PartTask& task) {
  std::vector<VertKey> wanted = strips.border.poor;
  wanted.insert(wanted.end(), strips.border.astray.begin(), strips.border.astray.end());
  Tellers tellers;
  for (const Message& message : task.inbox()) {
    for (const VertKey key : MessageReader(message.bytes).get_view<VertKey>()) {
      wanted.push_back(key);
      tellers.emplace_back(key, message.from);
    }
  }
  std::sort(wanted.begin(), wanted.end());
  sort_unique(tellers);
  strips.shared.clear();
  if (wanted.empty()) return;
  const NeighborBoxes boxes(input.decomposition, task.part());
  const auto neighbors = input.decomposition.neighbors(task.part());
  std::vector<std::vector<SharedVertNote>> lists(boxes.size());
  auto teller = tellers.begin();
  for (const auto& [vert, reach] : find_shared(part, strips.border, wanted)) {
    strips.shared.push_back(vert);
    const SharedVertNote told{vert.key, std::uint64_t{vert.is_poor}};
    const Vec3& x = part.mesh.points[vert.vert];
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

void send_strips(PartTets& part, StripState& strips, bool between_two, FillingPartsFigures::Strips& figures,
                 PartTask& task) {
  std::vector<Heard> heard;
  for (const Message& message : task.inbox())
    heard.push_back({message.from, MessageReader(message.bytes).get_view<SharedVertNote>()});
  std::vector<std::pair<PartId, std::uint32_t>> owned;
  std::vector<std::size_t> next(heard.size(), 0);
  for (const auto& vert : strips.shared) {
    PartId lowest = task.part();
    std::size_t sharers = 0;
    bool poor = vert.is_poor;
    figures.waiting += vert.is_poor;
    for (std::size_t i = 0; i < heard.size(); ++i) {
      const auto& list = heard[i].verts;
      while (next[i] < list.size() && list[next[i]].key < vert.key) ++next[i];
      if (next[i] == list.size() || list[next[i]].key != vert.key) continue;
      ++sharers;
      poor |= list[next[i]].is_poor != 0;
      lowest = std::min(lowest, heard[i].from);
    }
    if (!poor || sharers == 0 || (between_two && sharers > 1)) continue;
    owned.emplace_back(lowest, vert.vert);
  }
  strips.own_piece.clear();
  strips.opened.clear();
  if (owned.empty()) return;
  std::sort(owned.begin(), owned.end());
  strips.open_faces_changed = true;
  TetPacker packer(part.mesh);
  for (const auto& [to, tets] : find_tets_to_migrate(part.mesh, strips, owned)) {
    Bytes bytes = pack_piece(part, tets, packer);
    take_out(part, tets, strips.opened);
    figures.tets += tets.size();
    figures.moved += to == task.part() ? 0 : tets.size();
    if (to == task.part()) {
      strips.own_piece = std::move(bytes);
    } else {
      task.send(to, std::move(bytes));
    }
  }
}

void take_strips(const SharedInput& input, PartTets& part, StripState& strips, tets::OptimizeReport& report,
                 PartTask& task) {
  std::vector<Bytes> pieces;
  for (Message& message : task.inbox()) {
    if (!strips.own_piece.empty() && message.from > task.part()) pieces.push_back(std::exchange(strips.own_piece, {}));
    pieces.push_back(std::move(message.bytes));
  }
  if (!strips.own_piece.empty()) pieces.push_back(std::exchange(strips.own_piece, {}));
  std::erase_if(strips.open_faces, [&](FaceCode face) { return part.mesh.is_dead(face.tet()); });
  for (const FaceCode face : strips.opened)
    if (!part.mesh.is_dead(face.tet())) strips.open_faces.push_back(face);
  if (!pieces.empty()) {
    strips.open_faces_changed = true;
    KeyedTets strip = unpack_strip(std::move(pieces), task.runner());
    optimize_strip(input, strip, report, task.runner());
    put_in(part, task.part(), std::move(strip), strips.open_faces);
  }
  // Faces of the surface that taking out has opened are open for what comes back only.
  std::erase_if(strips.open_faces, [&](FaceCode face) { return part.mesh.is_fixed(face); });
  strips.opened.clear();
}

}  // namespace tetloom::parts

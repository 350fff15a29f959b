#include "adapt/parts/umbrellas.hpp"
#include "core/base/lists.hpp"
#include "tetloom/tasks.hpp"

#include <algorithm>
#include <span>

#include "core/base/disjoint_sets.hpp"
#include "threading/runtime/parallel_sort.hpp"

namespace tetloom::adapt {

namespace {

using EdgeVerts = std::array<std::uint32_t, 2>;

/// Where the outer surface is no surface: edges of more than two of its triangles, and vertices at which its triangles
/// do not follow each other around one umbrella.
class Pinches {
 public:
  Pinches(const WholeMesh& whole, const TaskRunner& runner) {
    std::vector<std::uint32_t> outer;
    for (std::uint32_t t = 0; t < whole.triangles.size(); ++t)
      if (whole.triangles[t].tets[1] == kNone) outer.push_back(t);
    const auto vert_at = [&](std::uint32_t corner) {
      return whole.triangles[outer[corner / 3]].triangle.verts[corner % 3];
    };
    struct Use {
      EdgeVerts verts;
      std::uint32_t corner;  // opposite to the edge
      auto operator<=>(const Use&) const = default;
    };
    std::vector<Use> uses(outer.size() * 3);
    for (std::uint32_t c = 0; c < uses.size(); ++c) {
      const std::uint32_t first = c / 3 * 3;
      uses[c] = {ascending(vert_at(first + (c + 1) % 3), vert_at(first + (c + 2) % 3)), c};
    }
    parallel_sort(uses, runner);
    DisjointSets corners(uses.size());
    for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
      for (end = i; end < uses.size() && uses[end].verts == uses[i].verts;) ++end;
      if (end - i > 2) edges.push_back(uses[i].verts);
      if (end - i != 2) continue;
      const std::uint32_t p = uses[i].corner / 3 * 3, q = uses[i + 1].corner / 3 * 3;
      for (std::uint32_t j = 0; j < 3; ++j)
        for (std::uint32_t k = 0; k < 3; ++k)
          if (vert_at(p + j) == vert_at(q + k)) corners.join(p + j, q + k);
    }
    std::vector<std::uint8_t> seen(whole.points.size(), 0);
    for (std::uint32_t c = 0; c < uses.size(); ++c) {
      if (corners.find(c) != c) continue;
      std::uint8_t& count = seen[vert_at(c)];
      if (count == 1) verts.push_back(vert_at(c));
      count = static_cast<std::uint8_t>(std::min(2, count + 1));
    }
    std::sort(verts.begin(), verts.end());
  }

  std::vector<EdgeVerts> edges;      ///< ascending
  std::vector<std::uint32_t> verts;  ///< ascending; the ends of all edges are among them
};

std::uint32_t first_free_corner(const WholeMesh& whole) {
  std::uint32_t first = 0;
  for (const PackedEntity packed : whole.to_entity) {
    const ModelEntity entity = packed.unpack();
    if (entity.valid() && entity.dim == 0) first = std::max(first, entity.index + 1);
  }
  return first;
}

class Separator {
 public:
  Separator(WholeMesh& whole, Pinches&& pinches) : whole_(whole), pinches_(std::move(pinches)) {}

  TouchingVerts run() {
    name_corners();
    find_balls();
    for (std::uint32_t slot = 0; slot < balls_.size(); ++slot) split_ball(slot);
    follow_triangles();
    follow_pieces();
    touching_.verts.assign(pinches_.verts.begin(), pinches_.verts.end());
    return std::move(touching_);
  }

 private:
  // Corners stay where they are.
  void name_corners() {
    touching_.first = first_free_corner(whole_);
    for (const std::uint32_t v : pinches_.verts) {
      const auto number = touching_.first + static_cast<std::uint32_t>(touching_.to_entity.size());
      touching_.to_entity.push_back(whole_.to_entity[v]);
      whole_.to_entity[v] = PackedEntity(ModelEntity(0, number));
    }
  }

  void find_balls() {
    to_slot_.assign(whole_.points.size(), kNone);
    for (std::uint32_t slot = 0; slot < pinches_.verts.size(); ++slot) to_slot_[pinches_.verts[slot]] = slot;
    balls_.resize(pinches_.verts.size());
    for (const FaceCode face : whole_.faces())
      if (const std::uint32_t slot = to_slot_[whole_.apex(face)]; slot != kNone) balls_[slot].push_back(face);
  }

  // Corners of tets at a vertex, those of each umbrella but the first with a new one.
  void split_ball(std::uint32_t slot) {
    const std::vector<FaceCode>& ball = balls_[slot];
    DisjointSets umbrellas(ball.size());
    for (std::uint32_t i = 0; i < ball.size(); ++i) {
      for (const FaceCode face : FaceCode::of(ball[i].tet())) {
        const FaceCode behind = whole_.behind(face);
        if (face == ball[i] || !behind.valid()) continue;
        const auto at = std::lower_bound(ball.begin(), ball.end(), FaceCode(behind.tet(), 0));
        umbrellas.join(i, static_cast<std::uint32_t>(at - ball.begin()));
      }
    }
    std::vector<std::uint32_t> to_vert(ball.size(), pinches_.verts[slot]);
    for (std::uint32_t i = 0; i < ball.size(); ++i) {
      const std::uint32_t umbrella = umbrellas.find(i);
      if (umbrella == i && i > 0) to_vert[i] = add_vert(pinches_.verts[slot]);
      whole_.to_vert[ball[i].index()] = to_vert[umbrella];
    }
  }

  std::uint32_t add_vert(std::uint32_t v) {
    whole_.points.push_back(Vec3(whole_.points[v])), whole_.to_entity.push_back(PackedEntity(whole_.to_entity[v]));
    if (!whole_.to_metric.empty()) whole_.to_metric.push_back(VertexMetric(whole_.to_metric[v]));
    whole_.to_hint.push_back(BackgroundTet{whole_.to_hint[v]});
    whole_.to_state.push_back(std::uint8_t{whole_.to_state[v]});
    to_slot_.push_back(to_slot_[v]);
    return static_cast<std::uint32_t>(whole_.points.size() - 1);
  }

  std::uint32_t given(std::uint32_t v) const { return to_slot_[v] == kNone ? v : pinches_.verts[to_slot_[v]]; }

  // The two tets of a triangle belong to the same umbrellas.
  void follow_triangles() {
    for (LinkedTriangle& t : whole_.triangles) {
      for (std::uint32_t& v : t.triangle.verts) {
        if (to_slot_[v] == kNone) continue;
        const std::uint32_t* verts = &whole_.to_vert[std::size_t{t.tets[0]} * 4];
        v = *std::find_if(verts, verts + 4, [&](std::uint32_t u) { return given(u) == v; });
      }
    }
  }

  // A piece of a model edge becomes one for each umbrella that has it.
  void follow_pieces() {
    std::vector<ModelEdgePiece> made;
    for (const auto& ball : balls_)
      for (const FaceCode corner : ball)
        for (const FaceCode other : FaceCode::of(corner.tet()))
          if (other != corner) follow_piece(whole_.apex(corner), whole_.apex(other), made);
    std::erase_if(whole_.edges, [&](const ModelEdgePiece& piece) {
      return to_slot_[piece.verts[0]] != kNone || to_slot_[piece.verts[1]] != kNone;
    });
    whole_.edges.insert(whole_.edges.end(), made.begin(), made.end());
    sort_pieces(whole_.edges);
  }

  void follow_piece(std::uint32_t a, std::uint32_t b, std::vector<ModelEdgePiece>& made) const {
    const EdgeVerts verts = ascending(given(a), given(b));
    const auto at = std::lower_bound(whole_.edges.begin(), whole_.edges.end(), ModelEdgePiece{verts, 0});
    if (at == whole_.edges.end() || at->verts != verts) return;
    const bool touches = std::binary_search(pinches_.edges.begin(), pinches_.edges.end(), verts);
    made.push_back({ascending(a, b), touches ? at->edge | kTouching : at->edge});
  }

  WholeMesh& whole_;
  Pinches pinches_;
  TouchingVerts touching_;
  std::vector<std::uint32_t> to_slot_;        // of every vertex: its place in pinches_.verts, or of what it was
  std::vector<std::vector<FaceCode>> balls_;  // corners of tets, ascending
};

// A vertex at which umbrellas touch, as all ranks know it.
struct TouchingVert {
  Number number = kNoNumber;
  PackedEntity entity;
  std::uint32_t added = 0;  // vertices of its umbrellas, behind the first
  auto operator<=>(const TouchingVert&) const = default;
};

// Those of all ranks, ascending.
std::vector<TouchingVert> gather_touching(const std::vector<TouchingVert>& own, const SharedWork& work) {
  std::vector<TouchingVert> all = gather_lists<TouchingVert>(work.ranks(), own);
  sort_unique(all);
  return all;
}

// From what one rank has said of its slice to what all say of the mesh.
class Renaming {
 public:
  Renaming(WholeMesh& whole, MeshSlice& slice, const TouchingVerts& own, const SharedWork& work)
      : whole_(whole), slice_(slice), own_(own), work_(work) {}

  TouchingVerts run() {
    const std::vector<TouchingVert> all = gather_touching(list_own(), work_);
    std::array<double, 1> first{static_cast<double>(own_.first)};
    work_.max(first);
    TouchingVerts touching;
    touching.first = static_cast<std::uint32_t>(first[0]);
    std::vector<Number> added{first_number() + slice_.vert_count};
    for (const TouchingVert& one : all) {
      touching.verts.push_back(one.number), touching.to_entity.push_back(one.entity);
      added.push_back(added.back() + one.added);
    }
    slice_.vert_count = added.back() - first_number();
    rename(touching, added);
    return touching;
  }

 private:
  bool touches(std::uint32_t vert) const {
    const ModelEntity entity = whole_.to_entity[vert].unpack();
    return entity.valid() && entity.dim == 0 && entity.index >= own_.first;
  }
  std::size_t slot_of(std::uint32_t vert) const { return whole_.to_entity[vert].unpack().index - own_.first; }

  std::vector<TouchingVert> list_own() const {
    std::vector<TouchingVert> list;
    for (std::size_t slot = 0; slot < own_.verts.size(); ++slot)
      list.push_back({slice_.to_vert_number[own_.verts[slot]], own_.to_entity[slot], 0});
    for (auto v = static_cast<std::uint32_t>(given_); v < whole_.points.size(); ++v) ++list[slot_of(v)].added;
    return list;
  }

  // New vertices stand by the vertex that they were, as their numbers do.
  void rename(const TouchingVerts& touching, std::vector<Number>& added) {
    for (std::uint32_t v = 0; v < whole_.points.size(); ++v) {
      if (!touches(v)) continue;
      const Number number = slice_.to_vert_number[own_.verts[slot_of(v)]];
      const auto slot =
          static_cast<std::uint32_t>(std::ranges::lower_bound(touching.verts, number) - touching.verts.begin());
      whole_.to_entity[v] = PackedEntity(ModelEntity(0, touching.first + slot));
      if (v >= given_) slice_.to_vert_number.push_back(added[slot]++), slice_.is_own.push_back(1);
    }
  }

  WholeMesh& whole_;
  MeshSlice& slice_;
  const TouchingVerts& own_;
  const SharedWork& work_;
  const std::size_t given_ = slice_.to_vert_number.size();  // vertices before there were new ones
};

}  // namespace

TouchingVerts separate_umbrellas(WholeMesh& whole, MeshSlice& slice, const SharedWork& work) {
  TouchingVerts own;
  own.first = first_free_corner(whole);
  Pinches pinches(whole, work.runner());
  std::erase_if(pinches.verts, [&](std::uint32_t v) { return slice.is_own[v] == 0; });
  if (!pinches.verts.empty()) own = Separator(whole, std::move(pinches)).run();
  return Renaming(whole, slice, own, work).run();
}

TouchingVerts separate_umbrellas(WholeMesh& whole, const TaskRunner& runner) {
  Pinches pinches(whole, runner);
  if (pinches.verts.empty()) return {};
  return Separator(whole, std::move(pinches)).run();
}

std::vector<std::array<std::uint32_t, 4>> tets_before_umbrellas(const WholeMesh& whole, const TouchingVerts& touching,
                                                                std::size_t given, const TaskRunner& runner) {
  auto tets = tets_of(whole, runner);
  if (whole.points.size() == given) return tets;
  for (auto& tet : tets)
    for (std::uint32_t& v : tet)
      if (v >= given)
        v = static_cast<std::uint32_t>(touching.verts[whole.to_entity[v].unpack().index - touching.first]);
  return tets;
}

std::vector<std::uint32_t> join_umbrellas(WholeMesh& whole, const TouchingVerts& touching) {
  std::vector<std::uint32_t> kept;
  if (touching.to_entity.empty()) return kept;
  std::vector<std::uint32_t> to_new(whole.points.size()), to_vert(touching.to_entity.size(), kNone);
  std::uint32_t count = 0;
  for (std::uint32_t v = 0; v < to_new.size(); ++v) {
    const ModelEntity entity = whole.to_entity[v].unpack();
    const bool touches = entity.valid() && entity.dim == 0 && entity.index >= touching.first;
    const std::uint32_t slot = touches ? entity.index - touching.first : kNone;
    if (touches && to_vert[slot] != kNone) {
      to_new[v] = to_vert[slot];
      continue;
    }
    to_new[v] = count;
    kept.push_back(v);
    if (touches) to_vert[slot] = count;
    whole.points[count] = whole.points[v], whole.to_metric[count] = whole.to_metric[v];
    whole.to_entity[count++] = touches ? touching.to_entity[slot] : whole.to_entity[v];
  }
  whole.points.resize(count), whole.to_metric.resize(count), whole.to_entity.resize(count);
  for (std::uint32_t& v : whole.to_vert) v = to_new[v];
  for (LinkedTriangle& t : whole.triangles)
    for (std::uint32_t& v : t.triangle.verts) v = to_new[v];
  for (ModelEdgePiece& piece : whole.edges)
    piece = {ascending(to_new[piece.verts[0]], to_new[piece.verts[1]]), piece.edge & ~kTouching};
  sort_pieces(whole.edges);
  return kept;
}

}  // namespace tetloom::adapt

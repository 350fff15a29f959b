// What comes out of a face that was meshed in pieces.
#include <algorithm>
#include <set>

#include "mesher/surface/face_in_pieces.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {
namespace {}  // namespace

// ---- edges that other faces have too ------------------------------------------------------------------------------

/// Side `side` of a kept triangle.
struct FaceInPieces::TakenChord {
  std::array<std::uint32_t, 2> verts;  // smaller first
  std::size_t part, triangle;
  std::uint32_t side;
  auto operator<=>(const TakenChord&) const = default;
};

std::vector<FaceInPieces::TakenChord> FaceInPieces::find_taken_chords() const {
  std::vector<TakenChord> sides;
  for (std::size_t p = 0; p < parts_.size(); ++p)
    for (std::size_t t = 0; t < parts_[p].kept.size(); ++t)
      for (std::uint32_t i = 0; i < 3; ++i) {
        const FaceTriangle& triangle = parts_[p].kept[t];
        const std::uint32_t a = triangle.verts[i], b = triangle.verts[(i + 1) % 3];
        if (a >= rim_count_ || b >= rim_count_ || (triangle.fixed >> i & 1)) continue;
        const auto [low, high] = std::minmax(cut_.vertices[a].node, cut_.vertices[b].node);
        if (std::ranges::binary_search(surroundings_.taken_chords, std::array{low, high}))
          sides.push_back({{std::min(a, b), std::max(a, b)}, p, t, i});
      }
  std::ranges::sort(sides);
  return sides;
}

void FaceInPieces::split_taken_chords() {
  if (surroundings_.taken_chords.empty()) return;
  const auto geometry = model_.face_geometry(face_);
  const PatchSurface surface(*geometry, surroundings_.sizes, cut_.scale);
  for (bool any = true; any;) {
    any = false;
    const std::vector<TakenChord> sides = find_taken_chords();
    std::set<std::array<std::size_t, 2>> changed;
    for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
      const TakenChord &one = sides[i], &other = sides[i + 1];
      if (one.verts != other.verts || changed.contains({one.part, one.triangle}) ||
          changed.contains({other.part, other.triangle}))
        continue;
      const PatchPlace middle = surface.midpoint(cut_.vertices[one.verts[0]].place, cut_.vertices[one.verts[1]].place);
      Part& part = parts_.back();
      const auto vertex = part.first + static_cast<std::uint32_t>(part.own.size());
      part.own.push_back({middle, surface.size_at(middle.point), kNone});
      for (const TakenChord* side : {&one, &other}) {
        split_at(*side, vertex);
        changed.insert({side->part, side->triangle});
      }
      any = true;
    }
  }
}

void FaceInPieces::split_at(const TakenChord& chord, std::uint32_t vertex) {
  FaceTriangle& first = parts_[chord.part].kept[chord.triangle];
  const std::uint32_t i = chord.side, j = (i + 1) % 3;
  FaceTriangle second = in_face(parts_[chord.part], first);
  first.verts[j] = vertex;
  second.verts[i] = vertex;
  first.fixed = static_cast<std::uint8_t>(first.fixed & ~(1u << j));
  second.fixed = static_cast<std::uint8_t>(second.fixed & (1u << j));
  parts_.back().kept.push_back(second);
}

// ---- the mesh of the face -----------------------------------------------------------------------------------------

// Two corners at one pole: no area.
bool FaceInPieces::has_area(const Part& part, const FaceTriangle& triangle) const {
  if (!cut_.has_poles) return true;
  std::array<std::uint32_t, 3> nodes{kNone, kNone, kNone};
  for (std::size_t i = 0; i < 3; ++i)
    if (triangle.verts[i] < rim_count_) nodes[i] = vertex_of(part, triangle.verts[i]).node;
  const auto same = [](std::uint32_t a, std::uint32_t b) { return a != kNone && a == b; };
  return !same(nodes[0], nodes[1]) && !same(nodes[1], nodes[2]) && !same(nodes[2], nodes[0]);
}

FaceMesh FaceInPieces::extract(const TaskRunner& runner) {
  FaceMesh mesh;
  std::vector<std::uint32_t> dropped;
  std::vector<std::size_t> first_triangle(parts_.size() + 1, 0), inverted(parts_.size(), 0);
  for (const Part& part : parts_) dropped.insert(dropped.end(), part.dropped.begin(), part.dropped.end());
  std::ranges::sort(dropped);
  const auto dropped_before = [&](std::uint32_t id) {
    return static_cast<std::uint32_t>(std::ranges::lower_bound(dropped, id) - dropped.begin());
  };
  runner.for_each(parts_.size(), [&](std::size_t p) {
    first_triangle[p + 1] = static_cast<std::size_t>(
        std::ranges::count_if(parts_[p].kept, [&](const FaceTriangle& t) { return has_area(parts_[p], t); }));
  });
  for (std::size_t p = 0; p < parts_.size(); ++p) first_triangle[p + 1] += first_triangle[p];
  const auto all = parts_.back().first + static_cast<std::uint32_t>(parts_.back().own.size());
  mesh.points.resize(all - rim_count_ - dropped.size());
  mesh.tri_to_vert.resize(first_triangle.back());
  const auto number = [&](std::uint32_t id) { return id - rim_count_ - dropped_before(id); };
  const auto put = [&](std::uint32_t id, const PatchVertex& vertex) {
    if (!std::ranges::binary_search(dropped, id)) mesh.points[number(id)] = vertex.place.point;
  };
  for (std::uint32_t v = rim_count_; v < cut_.vertices.size(); ++v) put(v, cut_.vertices[v]);
  runner.for_each(parts_.size(), [&](std::size_t p) {
    const Part& part = parts_[p];
    for (std::uint32_t i = 0; i < part.own.size(); ++i) put(part.first + i, part.own[i]);
    std::size_t next = first_triangle[p];
    for (const FaceTriangle& triangle : part.kept) {
      if (!has_area(part, triangle)) continue;
      const auto& [a, b, c] = triangle.verts;
      if (signed_quality(vertex_of(part, a).place, vertex_of(part, b).place, vertex_of(part, c).place) <= 0)
        ++inverted[p];
      std::array<std::uint32_t, 3> nodes = in_face(part, triangle).verts;
      for (std::uint32_t& v : nodes) v = v < rim_count_ ? cut_.vertices[v].node : FaceMesh::kInner | number(v);
      mesh.tri_to_vert[next++] = nodes;
    }
  });
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    mesh.inverted += inverted[p];
    if (inverted[p] > 0) mesh.point = vertex_of(parts_[p], parts_[p].kept.front().verts[0]).place.point;
  }
  return mesh;
}

}  // namespace tetloom

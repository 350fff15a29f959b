#include "mesher/tets/steiner.hpp"

#include <algorithm>
#include <unordered_map>

namespace tetloom::tets {

namespace {

constexpr std::size_t kSplitsPerTriangle = 8;

bool has_both(const TriangleVerts& t, std::uint32_t a, std::uint32_t b) {
  return std::find(t.begin(), t.end(), a) != t.end() && std::find(t.begin(), t.end(), b) != t.end();
}

TriangleVerts with(TriangleVerts t, std::uint32_t old, std::uint32_t fresh) {
  std::replace(t.begin(), t.end(), old, fresh);
  return t;
}

// Sectors of a ball: parts of it that fixed faces separate.
std::unordered_map<std::uint32_t, std::uint32_t> number_sectors(const LocalMesh& mesh, const TetList& ball) {
  std::unordered_map<std::uint32_t, std::uint32_t> sector_of;
  std::uint32_t count = 0;
  for (const std::uint32_t t : ball) sector_of[t] = kNone;
  for (const std::uint32_t seed : ball) {
    if (sector_of[seed] != kNone) continue;
    TetList stack{seed};
    sector_of[seed] = count;
    while (!stack.empty()) {
      const std::uint32_t t = stack.back();
      stack.pop_back();
      for (std::uint32_t k = 0; k < 4; ++k) {
        const FaceCode back = mesh.mesh().behind({t, k});
        if (!back.valid() || mesh.mesh().is_fixed({t, k})) continue;
        const auto at = sector_of.find(back.tet());
        if (at == sector_of.end() || at->second != kNone) continue;
        at->second = count;
        stack.push_back(back.tet());
      }
    }
    ++count;
  }
  return sector_of;
}

}  // namespace

std::uint32_t SteinerRecovery::add_piece(const TriangleVerts& verts, std::uint32_t root) {
  pieces_.push_back({verts, root});
  for (std::size_t i = 0; i < 3; ++i) kept_.insert(verts[i], verts[(i + 1) % 3]);
  return static_cast<std::uint32_t>(pieces_.size() - 1);
}

void SteinerRecovery::add(const TriangleVerts& triangle) {
  open_.push_back(add_piece(triangle, static_cast<std::uint32_t>(pieces_.size())));
}

bool SteinerRecovery::run(SteinerOrder order) {
  const std::vector<std::uint32_t> roots = open_;
  const std::size_t splits_at_most = kSplitsPerTriangle * pieces_.size();
  std::reverse(open_.begin(), open_.end());
  if (order == SteinerOrder::SidesFirst) realize_sides(splits_at_most);
  while (!open_.empty() && splits_.size() < splits_at_most && recoverer_.steps_left() > 0) {
    recoverer_.check_cancelled();
    const std::uint32_t piece = open_.back();
    open_.pop_back();
    if (!pieces_[piece].divided) realize(piece);
  }
  while (!splits_.empty() && undo(splits_.back())) {
    splits_.pop_back();
    recoverer_.check_cancelled();
  }
  release_pieces();
  const bool all_there =
      std::ranges::all_of(roots, [&](std::uint32_t root) { return mesh_.find_face(pieces_[root].verts).valid(); });
  if (!all_there) withdraw();
  return all_there;
}

// Takes the points that could not leave the triangles out of the mesh, as far as that is possible.
void SteinerRecovery::withdraw() {
  for (; !splits_.empty(); splits_.pop_back()) {
    recoverer_.check_cancelled();
    if (!recoverer_.remove_point(splits_.back().point, {})) return;
  }
}

// Sides of triangles before what lies inside of them: as long as a side is missing, what crosses it pierces the
// triangles beside it, nearer to the side with every point put there.
void SteinerRecovery::realize_sides(std::size_t splits_at_most) {
  for (std::uint32_t piece = 0; piece < pieces_.size(); ++piece) {
    for (std::size_t i = 0; i < 3 && !pieces_[piece].divided; ++i) {
      recoverer_.check_cancelled();
      if (splits_.size() >= splits_at_most || recoverer_.steps_left() == 0) return;
      const std::uint32_t a = pieces_[piece].verts[i], b = pieces_[piece].verts[(i + 1) % 3];
      const std::vector<std::uint32_t> parents = pieces_at(a, b);
      Obstacles why;
      if (is_inside(parents) || recoverer_.recover_edge(a, b, why) || why.blocked) continue;
      split_edge(a, b);
    }
  }
}

// Pieces that have the edge.
std::vector<std::uint32_t> SteinerRecovery::pieces_at(std::uint32_t a, std::uint32_t b) const {
  std::vector<std::uint32_t> found;
  for (std::uint32_t i = 0; i < pieces_.size(); ++i) {
    if (!pieces_[i].divided && has_both(pieces_[i].verts, a, b)) found.push_back(i);
  }
  return found;
}

// Whether the edge of these pieces lies inside of a triangle.
bool SteinerRecovery::is_inside(const std::vector<std::uint32_t>& parents) const {
  return parents.size() == 2 && pieces_[parents[0]].root == pieces_[parents[1]].root;
}

// What is left of divided triangles is no part of the surface.
void SteinerRecovery::release_pieces() {
  for (const SurfacePiece& piece : pieces_) {
    if (piece.divided || piece.verts == pieces_[piece.root].verts) continue;
    const FaceCode code = mesh_.find_face(piece.verts);
    if (code.valid()) mesh_.release(code);
  }
}

bool SteinerRecovery::realize(std::uint32_t piece) {
  const TriangleVerts verts = pieces_[piece].verts;
  for (std::size_t i = 0; i < 3; ++i) {
    Obstacles why;
    const std::uint32_t a = verts[i], b = verts[(i + 1) % 3];
    if (recoverer_.recover_edge(a, b, why)) continue;
    return !why.blocked && split_edge(a, b);
  }
  Obstacles why;
  if (recoverer_.recover_triangle(verts, why)) return true;
  return !why.blocked && split_piece(piece);
}

bool SteinerRecovery::split_edge(std::uint32_t a, std::uint32_t b) {
  const TetList obstacles = find_obstacles(mesh_, a, b).tets;
  const std::vector<std::uint32_t> parents = pieces_at(a, b);
  // Inside a triangle, what pierces it is split rather than what its division happens to meet: that comes to an end.
  if (is_inside(parents)) {
    for (const std::uint32_t piece : parents) {
      const std::uint32_t point = split_obstacle(mesh_, kept_, pieces_[piece].verts, obstacles);
      if (point == kNone) continue;
      divide({piece}, kNone, kNone, point);
      open_.push_back(parents[0] + parents[1] - piece);
      return true;
    }
  }
  const std::uint32_t point = split_obstacle(mesh_, kept_, a, b, obstacles);
  if (point == kNone) return false;
  divide(parents, a, b, point);
  return true;
}

bool SteinerRecovery::split_piece(std::uint32_t piece) {
  const TriangleVerts& verts = pieces_[piece].verts;
  const std::uint32_t point = split_obstacle(mesh_, kept_, verts, find_obstacles(mesh_, verts).tets);
  if (point == kNone) return false;
  divide({piece}, kNone, kNone, point);
  return true;
}

// At the edge ab, or, where there is none, inside.
void SteinerRecovery::divide(const std::vector<std::uint32_t>& parents, std::uint32_t a, std::uint32_t b,
                             std::uint32_t point) {
  PieceSplit split{point, parents, {}};
  for (const std::uint32_t parent : parents) {
    const SurfacePiece piece = pieces_[parent];
    pieces_[parent].divided = true;
    auto& children = split.children.emplace_back();
    for (const std::uint32_t v : piece.verts) {
      if (a != kNone && v != a && v != b) continue;
      children.push_back(add_piece(with(piece.verts, v, point), piece.root));
    }
    open_.insert(open_.end(), children.rbegin(), children.rend());
  }
  splits_.push_back(std::move(split));
}

bool SteinerRecovery::undo(const PieceSplit& split) {
  std::vector<TriangleVerts> parents;
  for (const std::uint32_t parent : split.parents) parents.push_back(pieces_[parent].verts);
  if (!has_children(split)) return false;
  if (!refill_sectors(split) && !recoverer_.remove_point(split.point, parents)) return false;
  for (const std::uint32_t parent : split.parents) {
    mesh_.fix(mesh_.find_face(pieces_[parent].verts));
    pieces_[parent].divided = false;
  }
  return true;
}

bool SteinerRecovery::has_children(const PieceSplit& split) const {
  for (const auto& children : split.children) {
    for (const std::uint32_t child : children) {
      const FaceCode code = mesh_.find_face(pieces_[child].verts);
      if (!code.valid() || !mesh_.mesh().is_fixed(code)) return false;
    }
  }
  return true;
}

// Without the point, or with another one inside of a sector.
bool SteinerRecovery::refill_sectors(const PieceSplit& split) {
  const TetList ball = mesh_.find_ball(split.point);
  const auto sector_of = number_sectors(mesh_, ball);
  std::vector<Sector> sectors(ball.size());
  for (const std::uint32_t t : ball) {
    const FaceCode outer(t, mesh_.corner_of(t, split.point));
    sectors[sector_of.at(t)].faces.push_back(mesh_.face(outer));
  }
  for (std::size_t i = 0; i < split.parents.size(); ++i) {
    const TriangleVerts verts = pieces_[split.parents[i]].verts;
    const FaceCode child = mesh_.find_face(pieces_[split.children[i].front()].verts);
    sectors[sector_of.at(child.tet())].faces.push_back(verts);
    sectors[sector_of.at(mesh_.mesh().behind(child).tet())].faces.push_back({verts[0], verts[2], verts[1]});
  }
  std::vector<Tet> fresh;
  for (const Sector& sector : sectors) {
    if (sector.faces.empty()) continue;
    const auto tets = fill_sector(mesh_, sector, split.point, options_);
    if (!tets) return false;
    fresh.insert(fresh.end(), tets->begin(), tets->end());
  }
  mesh_.replace(ball, fresh);
  return true;
}

}  // namespace tetloom::tets

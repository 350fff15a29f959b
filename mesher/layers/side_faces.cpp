#include "mesher/layers/side_faces.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "mesher/surface/rim_mesh.hpp"

namespace tetloom::layers {
namespace {

constexpr double kFlat = 1e-6;         // of the face's extent
constexpr double kRoomToVertex = 0.6;  // of the way to the end of a model edge
constexpr double kRoomToOther = 0.35;  // of the way to another curve on the same edge
constexpr double kNextNode = 0.4;      // wall edges: nodes nearer than that to the top are dropped

}  // namespace

SideFaces::SideFaces(const Mesh& mesh, std::span<const FaceSides> face_to_sides, const Walls& walls)
    : mesh_(mesh),
      face_to_sides_(face_to_sides),
      walls_(walls),
      face_to_side_(face_to_sides.size(), kNone),
      is_foot_(mesh.points.size(), 0),
      curves_(walls.curve_count()) {
  for (const std::uint32_t v : walls.curve_to_vert) is_foot_[v] = 1;
  find_sides();
  attach_curves();
  drop_ambiguous_feet();
  for (std::uint32_t c = 0; c < curves_.size(); ++c)
    if (curves_[c].count == 2 && !curves_[c].blocked) find_chain(c);
  block_shared_chains();
}

void SideFaces::find_sides() {
  for (const WallRim& rim : walls_.rims) {
    if (face_to_side_[rim.side_face] != kNone) continue;
    face_to_side_[rim.side_face] = static_cast<std::uint32_t>(sides_.size());
    sides_.emplace_back().face = rim.side_face;
  }
  for (std::uint32_t t = 0; t < mesh_.tri_to_vert.size(); ++t)
    if (const std::uint32_t side = face_to_side_[mesh_.tri_to_entity[t]]; side != kNone)
      sides_[side].triangles.push_back(t);
  for (Side& side : sides_) judge(side);
}

void SideFaces::judge(Side& side) const {
  Vec3 area;
  Box3 box;
  for (const std::uint32_t t : side.triangles) {
    const auto& [a, b, c] = mesh_.tri_to_vert[t];
    area += cross(mesh_.points[b] - mesh_.points[a], mesh_.points[c] - mesh_.points[a]);
    for (const std::uint32_t v : mesh_.tri_to_vert[t]) box.add(mesh_.points[v]);
  }
  const FaceSides& regions = face_to_sides_[side.face];
  side.is_usable = area != Vec3{} && regions.front.valid() != regions.back.valid();
  if (!side.is_usable) return;
  side.plane = SidePlane::through(mesh_.points[mesh_.tri_to_vert[side.triangles[0]][0]], normalized(area));
  side.is_usable = std::ranges::all_of(side.triangles, [&](std::uint32_t t) {
    const auto& [a, b, c] = mesh_.tri_to_vert[t];
    if (dot(cross(mesh_.points[b] - mesh_.points[a], mesh_.points[c] - mesh_.points[a]), side.plane.normal) <= 0)
      return false;
    return std::ranges::all_of(mesh_.tri_to_vert[t], [&](std::uint32_t v) {
      return std::abs(side.plane.height(mesh_.points[v])) <= kFlat * box.diagonal();
    });
  });
  if (!side.is_usable) return;
  find_rim(side);
  side.is_usable = !has_edges_inside(side);
}

void SideFaces::find_rim(Side& side) const {
  std::vector<HalfEdge> all;
  for (const std::uint32_t t : side.triangles)
    for (std::size_t i = 0; i < 3; ++i) all.push_back({mesh_.tri_to_vert[t][i], mesh_.tri_to_vert[t][(i + 1) % 3]});
  std::ranges::sort(all);
  for (const HalfEdge& edge : all)
    if (!std::ranges::binary_search(all, HalfEdge{edge[1], edge[0]})) side.rim.push_back(edge);
}

// Pieces of model edges, or of walls, that do not lie on the rim.
bool SideFaces::has_edges_inside(const Side& side) const {
  std::vector<HalfEdge> inner;
  for (const std::uint32_t t : side.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const HalfEdge edge{mesh_.tri_to_vert[t][i], mesh_.tri_to_vert[t][(i + 1) % 3]};
      if (edge[0] < edge[1] && !has_half_edge(side, edge[0], edge[1])) inner.push_back(edge);
    }
  std::ranges::sort(inner);
  return std::ranges::any_of(mesh_.edge_to_vert, [&](const HalfEdge& piece) {
    return std::ranges::binary_search(inner, HalfEdge{std::min(piece[0], piece[1]), std::max(piece[0], piece[1])});
  });
}

bool SideFaces::has_half_edge(const Side& side, std::uint32_t from, std::uint32_t to) const {
  return std::ranges::binary_search(side.rim, HalfEdge{from, to});
}

void SideFaces::attach_curves() {
  for (const WallRim& rim : walls_.rims) {
    const std::uint32_t side = face_to_side_[rim.side_face];
    const WallTriangle& wall = walls_.triangles[rim.wall];
    for (const std::uint32_t corner : {rim.corner, (rim.corner + 1) % 3}) attach(wall.curves[corner], side);
  }
}

void SideFaces::attach(std::uint32_t curve, std::uint32_t side) {
  CurveSides& at = curves_[curve];
  if (!sides_[side].is_usable) at.blocked = true;
  if (at.blocked || at.sides[0] == side || at.sides[1] == side) return;
  if (at.count == 2) {
    at.blocked = true;
    return;
  }
  at.sides[at.count++] = side;
  auto& curves = sides_[side].curves;
  curves.insert(std::ranges::upper_bound(curves, curve), curve);
}

// Where two curves of one side start at the same vertex, the rim cannot tell them apart.
void SideFaces::drop_ambiguous_feet() {
  for (Side& side : sides_) {
    std::unordered_map<std::uint32_t, std::uint32_t> foot_to_curve;  // looked up only
    for (const std::uint32_t c : side.curves) {
      const auto [known, is_new] = foot_to_curve.try_emplace(walls_.curve_to_vert[c], c);
      if (!is_new) curves_[known->second].blocked = curves_[c].blocked = true;
    }
  }
}

std::vector<std::uint32_t> SideFaces::neighbours(const Side& side, std::uint32_t vert, bool forward) const {
  std::vector<std::uint32_t> found;
  if (forward) {
    const auto first = std::ranges::lower_bound(side.rim, HalfEdge{vert, 0});
    for (auto i = first; i != side.rim.end() && (*i)[0] == vert; ++i) found.push_back((*i)[1]);
  } else {
    for (const HalfEdge& edge : side.rim)
      if (edge[1] == vert) found.push_back(edge[0]);
  }
  return found;
}

void SideFaces::find_chain(std::uint32_t curve) {
  CurveSides& at = curves_[curve];
  const std::uint32_t foot = walls_.curve_to_vert[curve];
  for (const bool forward : {true, false})
    for (const std::uint32_t next : neighbours(sides_[at.sides[0]], foot, forward)) {
      const bool is_shared =
          forward ? has_half_edge(sides_[at.sides[1]], next, foot) : has_half_edge(sides_[at.sides[1]], foot, next);
      if (is_shared && follow(curve, next, forward)) return;
    }
  at.blocked = true;
}

bool SideFaces::follow(std::uint32_t curve, std::uint32_t next, bool forward) {
  constexpr std::size_t kMostNodes = 1000;
  CurveSides& at = curves_[curve];
  const Vec3& foot = mesh_.points[walls_.curve_to_vert[curve]];
  at.along = normalized(mesh_.points[next] - foot);
  at.edge = mesh_.point_to_entity[next];
  while (mesh_.point_to_entity[next].dim == 1 && !is_foot_[next] && at.chain.size() < kMostNodes) {
    at.edge = mesh_.point_to_entity[next];
    at.chain.push_back(next);
    const std::vector<std::uint32_t> more = neighbours(sides_[at.sides[0]], next, forward);
    if (more.size() != 1) break;
    next = more[0];
  }
  at.room = (is_foot_[next] ? kRoomToOther : kRoomToVertex) * distance(foot, mesh_.points[next]);
  if (at.edge.dim != 1) {  // a single piece
    const std::uint32_t from = walls_.curve_to_vert[curve];
    for (std::size_t i = 0; i < mesh_.edge_to_vert.size(); ++i) {
      const auto& [a, b] = mesh_.edge_to_vert[i];
      if ((a == from && b == next) || (a == next && b == from)) at.edge = ModelEdgeId(mesh_.edge_to_entity[i]);
    }
  }
  return at.edge.dim == 1;
}

// A model edge that a third face has keeps its nodes.
void SideFaces::block_shared_chains() {
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> vert_to_curves;  // looked up only
  for (std::uint32_t c = 0; c < curves_.size(); ++c)
    for (const std::uint32_t v : curves_[c].chain) vert_to_curves[v].push_back(c);
  if (vert_to_curves.empty()) return;
  for (std::size_t t = 0; t < mesh_.tri_to_vert.size(); ++t) {
    const std::uint32_t side = face_to_side_[mesh_.tri_to_entity[t]];
    for (const std::uint32_t v : mesh_.tri_to_vert[t]) {
      const auto found = vert_to_curves.find(v);
      if (found == vert_to_curves.end()) continue;
      for (const std::uint32_t c : found->second)
        if (side == kNone || (side != curves_[c].sides[0] && side != curves_[c].sides[1])) curves_[c].blocked = true;
    }
  }
}

Vec3 SideFaces::constrain(std::uint32_t curve, const Vec3& direction) const {
  const CurveSides& at = curves_[curve];
  if (at.count == 0 || at.blocked) return direction;
  if (at.count == 2) return at.along;
  const Vec3& normal = sides_[at.sides[0]].plane.normal;
  return normalized(direction - dot(direction, normal) * normal);
}

Vec3 SideFaces::put(std::uint32_t curve, const Vec3& x) const {
  const CurveSides& at = curves_[curve];
  if (at.count == 0 || at.blocked) return x;
  const Vec3 on_first = sides_[at.sides[0]].plane.project(x);
  return at.count == 1 ? on_first : sides_[at.sides[1]].plane.project(on_first);
}

ModelEntity SideFaces::entity_of(std::uint32_t curve) const {
  const CurveSides& at = curves_[curve];
  if (at.count == 2) return at.edge;
  if (at.count == 1) return ModelFaceId(sides_[at.sides[0]].face);
  return ModelRegionId(walls_.triangles[walls_.triangles_at(curve)[0]].region);
}

std::vector<std::uint32_t> SideFaces::dropped_by(std::uint32_t curve, const CurveTop& top) const {
  const CurveSides& at = curves_[curve];
  std::vector<std::uint32_t> dropped;
  if (!top.grows || at.count != 2) return dropped;
  const Vec3& foot = mesh_.points[walls_.curve_to_vert[curve]];
  for (const std::uint32_t v : at.chain) {
    if (distance(foot, mesh_.points[v]) > top.thickness + kNextNode * walls_.curve_to_width[curve]) break;
    dropped.push_back(v);
  }
  return dropped;
}

SideMesh SideFaces::mesh_rest(std::size_t side_index, std::span<const CurveTop> tops, const SizeField& sizes,
                              const std::function<bool()>& keep_going) const {
  const Side& side = sides_[side_index];
  std::unordered_map<std::uint32_t, std::uint32_t> vert_to_curve;  // looked up only
  for (const std::uint32_t c : side.curves) {
    if (!tops[c].grows) continue;
    vert_to_curve[walls_.curve_to_vert[c]] = c;
    for (const std::uint32_t v : dropped_by(c, tops[c])) vert_to_curve[v] = c;
  }
  SideMesh result;
  result.face = side.face;
  FaceRim rim;
  std::vector<Vec3> points;
  std::unordered_map<std::uint64_t, std::uint32_t> known;  // looked up only
  const auto node_of = [&](std::uint32_t vert) {
    const auto found = vert_to_curve.find(vert);
    const bool is_top = found != vert_to_curve.end();
    const std::uint64_t key = is_top ? (std::uint64_t{1} << 32) + found->second : vert;
    const auto [node, is_new] = known.try_emplace(key, static_cast<std::uint32_t>(points.size()));
    if (is_new) {
      points.push_back(is_top ? tops[found->second].point : mesh_.points[vert]);
      result.nodes.push_back(is_top ? SideMesh::Node{kNone, found->second} : SideMesh::Node{vert, kNone});
      rim.vertices.push_back({node->second, side.plane.to_plane(points.back())});
    }
    return node->second;
  };
  for (const auto& [a, b] : side.rim) {
    const std::uint32_t from = node_of(a), to = node_of(b);
    if (from == to) continue;
    rim.segments.push_back({from, to});
    rim.segment_to_edge.emplace_back();
  }
  const std::unique_ptr<FaceGeometry> geometry = make_geometry(side.plane);
  result.mesh = mesh_in_rim(std::move(rim), *geometry, points, sizes, keep_going);
  return result;
}

}  // namespace tetloom::layers

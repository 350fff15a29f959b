#include "mesher/layers/side_faces.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "core/base/lists.hpp"

namespace tetloom::layers {
namespace {

constexpr double kFlat = 1e-6;         // of the face's extent
constexpr double kUpright = 0.35;      // cosine between a plane's normal and those of what stands over it
constexpr double kRoomToVertex = 0.6;  // of the way to the end of a model edge
constexpr double kRoomToOther = 0.35;  // of the way to another curve on the same edge
constexpr double kNextNode = 0.4;      // wall edges: nodes nearer than that to the top are dropped

Vec3 area_of(const Mesh& mesh, std::uint32_t triangle) {
  const auto& [a, b, c] = mesh.tri_to_vert[triangle];
  return cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]);
}

// The plane that fits the triangles, of which some points lie no farther away than `height`, and none of which leans
// more than `upright` allows. Of none, the plane has no normal.
struct PlaneFit {
  SidePlane plane;
  bool exists = false;
  double height = 0;   // of the triangles' extent
  double upright = 1;  // least cosine
};

PlaneFit fit_plane(const Mesh& mesh, std::span<const std::uint32_t> triangles) {
  PlaneFit fit;
  Vec3 area;
  Box3 box;
  for (const std::uint32_t t : triangles) {
    area += area_of(mesh, t);
    for (const std::uint32_t v : mesh.tri_to_vert[t]) box.add(mesh.points[v]);
  }
  if (area == Vec3{}) return fit;
  fit.exists = true;
  fit.plane = SidePlane::through(mesh.points[mesh.tri_to_vert[triangles[0]][0]], normalized(area));
  for (const std::uint32_t t : triangles) {
    fit.upright = std::min(fit.upright, dot(normalized(area_of(mesh, t)), fit.plane.normal));
    for (const std::uint32_t v : mesh.tri_to_vert[t])
      fit.height = std::max(fit.height, std::abs(fit.plane.height(mesh.points[v])) / box.diagonal());
  }
  return fit;
}

}  // namespace

SideFaces::SideFaces(const GeometricModel& model, const Mesh& mesh, const Walls& walls, const TaskRunner& runner)
    : model_(model),
      mesh_(mesh),
      walls_(walls),
      face_to_side_(model.topology().face_count(), kNone),
      curve_to_sides_(walls.curve_count(), kNone) {
  if (walls.rims.empty()) return;
  is_foot_.assign(mesh.points.size(), 0);
  for (const std::uint32_t v : walls.curve_to_vert) is_foot_[v] = 1;
  for (const auto& [a, b] : mesh.edge_to_vert) pieces_.push_back({std::min(a, b), std::max(a, b)});
  std::ranges::sort(pieces_);
  find_sides(runner);
  attach_curves();
  block_ambiguous_feet();
  for (CurveSides& curve : curves_)
    if (!curve.is_blocked) find_chain(curve);
  block_shared_chains();
}

void SideFaces::find_sides(const TaskRunner& runner) {
  for (const WallRim& rim : walls_.rims) {
    if (face_to_side_[rim.side_face] != kNone) continue;
    face_to_side_[rim.side_face] = static_cast<std::uint32_t>(sides_.size());
    sides_.emplace_back().shape.face = ModelFaceId(rim.side_face);
  }
  for (std::uint32_t t = 0; t < mesh_.tri_to_vert.size(); ++t)
    if (const std::uint32_t side = face_to_side_[mesh_.tri_to_entity[t]]; side != kNone)
      sides_[side].triangles.push_back(t);
  runner.for_each(sides_.size(), [&](std::size_t s) { judge(sides_[s]); });
}

// The first of the planes that serves.
void SideFaces::judge(SideFace& side) const {
  const FaceSides& regions = model_.topology().face_to_sides[side.shape.face.value];
  side.is_usable = regions.front.valid() != regions.back.valid();
  if (!side.is_usable) return;
  const PlaneFit fit = fit_plane(mesh_, side.triangles);
  side.shape.plane = fit.plane;
  const bool is_smooth = model_.face_geometry(side.shape.face)->parametrization() == Parametrization::Smooth;
  for (const SideKind kind : {SideKind::Flat, SideKind::Parametric, SideKind::Upright}) {
    if (kind == SideKind::Flat && !(fit.exists && fit.height <= kFlat)) continue;
    if (kind == SideKind::Parametric && !is_smooth) continue;
    if (kind == SideKind::Upright && !(fit.exists && fit.upright > kUpright)) continue;
    side.shape.kind = kind;
    const std::unique_ptr<FaceGeometry> geometry = side.shape.make_geometry(model_);
    SidePlacer placer(model_, mesh_, side.shape, *geometry);
    side.rim = find_rim(mesh_, side.triangles, pieces_, placer);
    if (!side.rim.empty()) return;
  }
  side.is_usable = false;
}

bool SideFaces::has_piece(const SideFace& side, std::uint32_t from, std::uint32_t to) const {
  return std::ranges::binary_search(side.rim, std::array{from, to}, {}, &RimPiece::verts);
}

void SideFaces::attach_curves() {
  for (const WallRim& rim : walls_.rims) {
    const std::uint32_t side = face_to_side_[rim.side_face];
    const WallTriangle& wall = walls_.triangles[rim.wall];
    for (const std::uint32_t corner : {rim.corner, (rim.corner + 1) % 3}) {
      attach(wall.curves[corner], side);
      curves_[curve_to_sides_[wall.curves[corner]]].into += into_side(rim);
    }
  }
  std::ranges::sort(curves_, {}, &CurveSides::curve);
  for (std::uint32_t i = 0; i < curves_.size(); ++i) curve_to_sides_[curves_[i].curve] = i;
}

// Normal to the rim, within the triangle of the side face.
Vec3 SideFaces::into_side(const WallRim& rim) const {
  const auto& verts = walls_.triangles[rim.wall].verts;
  const Vec3 &from = mesh_.points[verts[rim.corner]], &to = mesh_.points[verts[(rim.corner + 1) % 3]];
  const Vec3 edge = normalized(to - from);
  Vec3 across;
  for (const std::uint32_t v : mesh_.tri_to_vert[rim.side_triangle]) {
    const Vec3 way = mesh_.points[v] - from, aside = way - dot(way, edge) * edge;
    if (norm2(aside) > norm2(across)) across = aside;
  }
  return normalized(across);
}

void SideFaces::attach(std::uint32_t curve, std::uint32_t side) {
  if (curve_to_sides_[curve] == kNone) {
    curve_to_sides_[curve] = static_cast<std::uint32_t>(curves_.size());
    curves_.emplace_back().curve = curve;
  }
  CurveSides& at = curves_[curve_to_sides_[curve]];
  if (!sides_[side].is_usable) at.is_blocked = true;
  if (at.is_blocked || at.sides[0] == side || at.sides[1] == side) return;
  if (at.count == 2) {
    at.is_blocked = true;
    return;
  }
  at.sides[at.count++] = side;
  auto& curves = sides_[side].curves;
  curves.insert(std::ranges::upper_bound(curves, curve), curve);
}

// Where two curves of one side start at the same vertex, the rim cannot tell them apart.
void SideFaces::block_ambiguous_feet() {
  for (const SideFace& side : sides_) {
    std::unordered_map<std::uint32_t, std::uint32_t> foot_to_curve;  // looked up only
    for (const std::uint32_t c : side.curves) {
      const auto [known, is_new] = foot_to_curve.try_emplace(walls_.curve_to_vert[c], c);
      if (is_new) continue;
      for (const std::uint32_t both : {known->second, c}) curves_[curve_to_sides_[both]].is_blocked = true;
    }
  }
}

std::vector<std::uint32_t> SideFaces::next_on_rim(const SideFace& side, std::uint32_t vert, bool forward) const {
  std::vector<std::uint32_t> found;
  if (forward) {
    auto i = std::ranges::lower_bound(side.rim, std::array{vert, 0u}, {}, &RimPiece::verts);
    for (; i != side.rim.end() && i->verts[0] == vert; ++i) found.push_back(i->verts[1]);
  } else {
    for (const RimPiece& piece : side.rim)
      if (piece.verts[1] == vert) found.push_back(piece.verts[0]);
  }
  return found;
}

// Where model edges lead away from the foot that the curve has to run along: edges between its sides, and seams.
std::vector<std::uint32_t> SideFaces::edges_from(const CurveSides& at) const {
  const std::uint32_t foot = walls_.curve_to_vert[at.curve];
  std::vector<std::uint32_t> found;
  for (std::size_t i = 0; i < at.count; ++i)
    for (std::size_t k = i; k < at.count; ++k) {
      const SideFace &one = sides_[at.sides[i]], &other = sides_[at.sides[k]];
      for (const std::uint32_t next : next_on_rim(one, foot, true))
        if (has_piece(other, next, foot)) found.push_back(next);
      if (i == k) continue;
      for (const std::uint32_t next : next_on_rim(one, foot, false))
        if (has_piece(other, foot, next)) found.push_back(next);
    }
  sort_unique(found);
  return found;
}

void SideFaces::find_chain(CurveSides& at) {
  const std::vector<std::uint32_t> edges = edges_from(at);
  if (edges.empty() && at.count == 1) return;
  at.is_along_edge = true;
  if (edges.size() != 1 || !follow(at, edges[0])) at.is_blocked = true;
}

bool SideFaces::follow(CurveSides& at, std::uint32_t next) {
  constexpr std::size_t kMostNodes = 1000;
  const SideFace& side = sides_[at.sides[0]];
  std::uint32_t before = walls_.curve_to_vert[at.curve];
  const Vec3& foot = mesh_.points[before];
  const bool forward = has_piece(side, before, next);
  at.next = next;
  at.along = normalized(mesh_.points[next] - foot);
  while (mesh_.point_to_entity[next].dim == 1 && !is_foot_[next] && at.chain.size() < kMostNodes) {
    at.edge = mesh_.point_to_entity[next];
    at.chain.push_back(next);
    std::vector<std::uint32_t> more = next_on_rim(side, next, forward);
    std::erase(more, before);
    if (more.size() != 1) break;
    before = std::exchange(next, more[0]);
  }
  at.room = (is_foot_[next] ? kRoomToOther : kRoomToVertex) * distance(foot, mesh_.points[next]);
  if (at.edge.dim == 1) return true;
  const std::uint32_t from = walls_.curve_to_vert[at.curve];  // a single piece
  for (std::size_t i = 0; i < mesh_.edge_to_vert.size(); ++i) {
    const auto& [a, b] = mesh_.edge_to_vert[i];
    if ((a == from && b == next) || (a == next && b == from)) at.edge = ModelEdgeId(mesh_.edge_to_entity[i]);
  }
  return at.edge.dim == 1;
}

// A model edge that a third face has keeps its nodes.
void SideFaces::block_shared_chains() {
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> vert_to_curves;  // looked up only
  for (std::uint32_t i = 0; i < curves_.size(); ++i)
    for (const std::uint32_t v : curves_[i].chain) vert_to_curves[v].push_back(i);
  if (vert_to_curves.empty()) return;
  for (std::size_t t = 0; t < mesh_.tri_to_vert.size(); ++t) {
    const std::uint32_t side = face_to_side_[mesh_.tri_to_entity[t]];
    for (const std::uint32_t v : mesh_.tri_to_vert[t]) {
      const auto found = vert_to_curves.find(v);
      if (found == vert_to_curves.end()) continue;
      for (const std::uint32_t i : found->second)
        if (side == kNone || std::ranges::count(curves_[i].sides, side) == 0) curves_[i].is_blocked = true;
    }
  }
}

ModelEntity SideFaces::entity_of(std::uint32_t curve) const {
  const CurveSides* at_sides = at(curve);
  if (at_sides && at_sides->is_along_edge) return at_sides->edge;
  if (at_sides && at_sides->count == 1) return sides_[at_sides->sides[0]].shape.face;
  return ModelRegionId(walls_.curve_to_region[curve]);
}

std::vector<std::uint32_t> SideFaces::dropped_by(std::uint32_t curve, const CurveTop& top) const {
  std::vector<std::uint32_t> dropped;
  if (!top.grows || !is_along_edge(curve)) return dropped;
  const Vec3& foot = mesh_.points[walls_.curve_to_vert[curve]];
  for (const std::uint32_t v : at(curve)->chain) {
    if (distance(foot, mesh_.points[v]) > top.thickness + kNextNode * walls_.curve_to_width[curve]) break;
    dropped.push_back(v);
  }
  return dropped;
}

FaceGeometry& SideProjector::face(std::uint32_t side) {
  std::unique_ptr<FaceGeometry>& geometry = faces_[side];
  if (!geometry) geometry = sides_.sides()[side].shape.make_geometry(sides_.model());
  return *geometry;
}

EdgeGeometry& SideProjector::edge(std::uint32_t edge) {
  std::unique_ptr<EdgeGeometry>& geometry = edges_[edge];
  if (!geometry) geometry = sides_.model().edge_geometry(ModelEdgeId(edge));
  return *geometry;
}

SidePlace SideProjector::at_foot(const CurveSides& curve) {
  const Vec3& foot = sides_.mesh().points[sides_.walls().curve_to_vert[curve.curve]];
  SidePlace from{foot, {}, curve.along, {}};
  if (!curve.is_along_edge) from.uv = face(curve.sides[0]).closest_point(foot, {}).uv;
  SidePlace place = put(curve, foot, from);
  place.point = foot;
  return place;
}

SidePlace SideProjector::put(const CurveSides& curve, const Vec3& x, const SidePlace& from) {
  if (curve.is_along_edge) return put_on_edge(curve, x, from);
  FaceGeometry& geometry = face(curve.sides[0]);
  const SurfacePoint nearest = geometry.closest_point(x, from.uv);
  const Vec3 normal = geometry.normal(nearest.uv);
  return {nearest.point, normal == Vec3{} ? from.normal : normal, {}, nearest.uv};
}

// Between flat faces an edge is straight, and exact where the faces are.
SidePlace SideProjector::put_on_edge(const CurveSides& curve, const Vec3& x, const SidePlace& from) {
  SidePlace place = from;
  const SideShape &one = sides_.sides()[curve.sides[0]].shape, &other = sides_.sides()[curve.sides.back()].shape;
  if (curve.count == 2 && one.kind == SideKind::Flat && other.kind == SideKind::Flat) {
    place.point = other.plane.project(one.plane.project(x));
    return place;
  }
  EdgeGeometry& geometry = edge(curve.edge.index);
  const CurvePoint nearest = geometry.closest_point(x);
  const Vec3 along = normalized(geometry.derivative(nearest.t));
  place.point = nearest.point;
  if (along != Vec3{}) place.along = dot(along, from.along) < 0 ? -along : along;
  return place;
}

}  // namespace tetloom::layers

#include "adapt/metric/curvature_limits.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "core/base/lists.hpp"
#include "core/geometry/bad_geometry.hpp"
#include "core/sizing/curvature_size.hpp"
#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {
namespace {

/// Appends the vertices of the elements of each entity of one dimension, ascending.
template <class Element>
void add_verts(const std::vector<Element>& elements, const std::vector<std::uint32_t>& entities, std::size_t count,
               const char* kind, std::vector<std::vector<std::uint32_t>>& all) {
  const std::size_t first = all.size();
  all.resize(first + count);
  for (std::size_t e = 0; e < elements.size(); ++e) {
    if (entities[e] == kNone) continue;
    if (entities[e] >= count)
      throw Error(ErrorCode::InputUnsuitable, "the mesh has a " + std::string(kind) + " " +
                                                  std::to_string(std::uint64_t{entities[e]} + 1) +
                                                  ", but the model has only " + std::to_string(count));
    std::vector<std::uint32_t>& verts = all[first + entities[e]];
    verts.insert(verts.end(), elements[e].begin(), elements[e].end());
  }
  for (std::size_t i = first; i < all.size(); ++i) sort_unique(all[i]);
}

/// The unit tangent in which the surface curves most, by differences of normals; none where they do not tell, or tell
/// of another curvature than the face does.
std::optional<Vec3> principal_direction(FaceGeometry& face, const Vec2& uv, const Vec3& normal,
                                        const PrincipalCurvatures& k) {
  if (face.parametrization() != Parametrization::Smooth) return {};
  const SurfaceDerivatives d = face.derivatives(uv);
  const double lu = norm(d.du), lv = norm(d.dv);
  if (!(norm(cross(d.du, d.dv)) > 1e-6 * lu * lv) || !(lu > 0) || !(lv > 0)) return {};
  const ParameterBox box = face.parameter_box();
  constexpr double kStep = 1e-4;  // of the parameter range
  const double su = kStep * (box.hi.u - box.lo.u), sv = kStep * (box.hi.v - box.lo.v);
  const auto difference = [&](const Vec2& step, double length) {
    return (face.normal(uv + step) - face.normal(uv - step)) / (2 * length);
  };
  const Vec3 nu = difference({su, 0}, su), nv = difference({0, sv}, sv);
  // An orthonormal frame a, b of the tangent plane, in which du = lu a and dv = p a + q b.
  const Vec3 a = d.du / lu, b = cross(normal, a);
  const double p = dot(d.dv, a), q = dot(d.dv, b);
  const Vec3 along_a = nu / lu, along_b = (nv - p * along_a) / q;  // derivatives of the normal
  const double aa = dot(along_a, a), ab = 0.5 * (dot(along_a, b) + dot(along_b, a)), bb = dot(along_b, b);
  // The two principal directions; of those the one with the larger curvature.
  const double angle = 0.5 * std::atan2(2 * ab, aa - bb);
  const double c = std::cos(angle), s = std::sin(angle);
  const double first = aa * c * c + 2 * ab * c * s + bb * s * s, second = aa + bb - first;
  const double largest = std::max(std::abs(first), std::abs(second));
  constexpr double kAgreement = 0.1;
  if (!(std::abs(largest - std::abs(k.largest)) <= kAgreement * std::abs(k.largest))) return {};
  return std::abs(first) >= std::abs(second) ? c * a + s * b : c * b - s * a;
}

std::optional<VertexLimit> limit_on_face(FaceGeometry& face, const Vec2& uv, const CurvatureLimits& limits) {
  const PrincipalCurvatures k = face.curvature(uv);
  const Vec3 normal = face.normal(uv);
  const double h = std::max(limits.h_min, size_from_curvature(k, limits.edges_per_turn));
  if (!(h > 0) || !std::isfinite(h) || !(norm2(normal) > 0.5)) return {};
  const std::optional<Vec3> found = principal_direction(face, uv, normal, k);
  const Vec3 helper = std::abs(normal.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  VertexLimit limit;
  limit.directions[0] = normalized(cross(cross(normal, found ? *found : helper), normal));
  limit.directions[1] = cross(normal, limit.directions[0]);
  const double stretch = found && std::abs(k.largest) > 0 ? std::abs(k.largest / k.smallest) : 1;
  limit.sizes = {h, stretch > 1 ? h * stretch : h};  // infinite where the other curvature is 0
  return limit;
}

std::vector<VertexLimit> limits_of_face(const GeometricModel& model, ModelFaceId id,
                                        std::span<const std::uint32_t> verts, std::span<const Vec3> points,
                                        const CurvatureLimits& limits) {
  std::vector<VertexLimit> found;
  if (verts.empty()) return found;
  const std::unique_ptr<FaceGeometry> face = model.face_geometry(id);
  std::optional<Vec2> guess;
  for (const std::uint32_t v : verts) {
    const SurfacePoint at = face->closest_point(points[v], guess);
    guess = at.uv;
    if (std::optional<VertexLimit> limit = limit_on_face(*face, at.uv, limits)) {
      limit->vert = v;
      found.push_back(*limit);
    }
  }
  return found;
}

std::vector<VertexLimit> limits_of_edge(const GeometricModel& model, ModelEdgeId id,
                                        std::span<const std::uint32_t> verts, std::span<const Vec3> points,
                                        const CurvatureLimits& limits) {
  std::vector<VertexLimit> found;
  if (verts.empty() || model.topology().edges[id.value].degenerate) return found;
  const std::unique_ptr<EdgeGeometry> edge = model.edge_geometry(id);
  for (const std::uint32_t v : verts) {
    const double t = edge->closest_point(points[v]).t;
    const double h = std::max(limits.h_min, size_from_edge_curvature(edge->curvature(t), limits.edges_per_turn));
    const Vec3 tangent = normalized(edge->derivative(t));
    if (!(h > 0) || !std::isfinite(h) || !(norm2(tangent) > 0.5)) continue;
    const Vec3 helper = std::abs(tangent.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    found.push_back({v, {tangent, normalized(cross(tangent, helper))}, {h, HUGE_VAL}});
  }
  return found;
}

/// The metric with those sizes, and along the directions without one as large a size as nothing else needs.
Tensor tensor_of(const VertexLimit& limit, double smallest_eigenvalue) {
  const Vec3 normal = cross(limit.directions[0], limit.directions[1]);
  Tensor m = outer(normal, smallest_eigenvalue);
  for (std::size_t i = 0; i < 2; ++i) {
    const double asked = 1 / (limit.sizes[i] * limit.sizes[i]);
    m += outer(limit.directions[i], std::max(asked, smallest_eigenvalue));
  }
  return m;
}

}  // namespace

void require_valid(const CurvatureLimits& limits) {
  if (limits.edges_per_turn > 0 && std::isfinite(limits.edges_per_turn) && limits.h_min >= 0) return;
  throw Error(ErrorCode::InvalidArgument,
              "curvature limits need a positive number of edges per turn, and no negative size");
}

std::vector<std::vector<std::uint32_t>> verts_by_entity(const Mesh& mesh, const ModelTopology& topology) {
  std::vector<std::vector<std::uint32_t>> all;
  add_verts(mesh.tri_to_vert, mesh.tri_to_entity, topology.face_count(), "face", all);
  add_verts(mesh.edge_to_vert, mesh.edge_to_entity, topology.edge_count(), "edge", all);
  return all;
}

std::vector<VertexLimit> limits_of_entity(const GeometricModel& model, std::size_t entity,
                                          std::span<const std::uint32_t> verts, std::span<const Vec3> points,
                                          const CurvatureLimits& limits) {
  const std::size_t faces = model.topology().face_count();
  std::vector<VertexLimit> found;
  tolerate_bad_geometry([&] {
    found = entity < faces ? limits_of_face(model, ModelFaceId(entity), verts, points, limits)
                           : limits_of_edge(model, ModelEdgeId(entity - faces), verts, points, limits);
  });
  return found;
}

bool apply(MetricField& metric, const VertexLimit& limit) {
  const Tensor m = metric.at(limit.vert);
  const double smallest = std::exp(eigen(metric.logs[limit.vert]).values[0]);
  const Tensor both = intersection(m, tensor_of(limit, smallest));
  if (both == m) return false;
  metric.logs[limit.vert] = log(both);
  return true;
}

std::size_t limit_by_curvature(MetricField& metric, const Mesh& mesh, const GeometricModel& model,
                               const CurvatureLimits& limits, const TaskRunner& runner) {
  require_valid(limits);
  if (metric.size() != mesh.points.size())
    throw Error(ErrorCode::InvalidArgument, "a metric at " + std::to_string(metric.size()) + " vertices does not fit " +
                                                std::to_string(mesh.points.size()));
  const auto entity_verts = verts_by_entity(mesh, model.topology());
  std::vector<std::vector<VertexLimit>> found(entity_verts.size());
  std::vector<double> work;
  for (const auto& verts : entity_verts) work.push_back(static_cast<double>(verts.size()));
  runner.for_each_largest_first(
      work, [&](std::size_t i) { found[i] = limits_of_entity(model, i, entity_verts[i], mesh.points, limits); });
  std::vector<std::uint32_t> changed;
  for (const std::vector<VertexLimit>& of_entity : found)
    for (const VertexLimit& limit : of_entity)
      if (apply(metric, limit)) changed.push_back(limit.vert);
  sort_unique(changed);
  return changed.size();
}

}  // namespace tetloom::adapt

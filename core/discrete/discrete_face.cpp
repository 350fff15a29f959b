#include "core/discrete/discrete_face.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tetloom::detail {
namespace {

Vec2 encode(std::uint32_t tri, double b1, double b2) { return {2.0 * tri + b1, b2}; }

}  // namespace

DiscreteFace::DiscreteFace(std::shared_ptr<const FaceFacets> facets,
                           std::shared_ptr<const std::vector<double>> edge_lengths)
    : held_(std::move(facets)), facets_(*held_), edge_lengths_(std::move(edge_lengths)) {}

DiscreteFace::Place DiscreteFace::decode(const Vec2& uv) const {
  const double last = static_cast<double>(facets_.tri_to_vert.size() - 1);
  const double tri = std::clamp(std::floor(uv.u / 2), 0.0, last);
  const double b1 = std::clamp(uv.u - 2 * tri, 0.0, 1.0), b2 = std::clamp(uv.v, 0.0, 1.0);
  return {static_cast<std::uint32_t>(tri), 1 - b1 - b2, b1, b2};
}

ParameterBox DiscreteFace::parameter_box() {
  return {{0, 0}, {2.0 * static_cast<double>(facets_.tri_to_vert.size()) - 1, 1}};
}

Vec3 DiscreteFace::evaluate(const Vec2& uv) {
  const Place p = decode(uv);
  return p.b0 * corner(p, 0) + p.b1 * corner(p, 1) + p.b2 * corner(p, 2);  // exact at the corners
}

SurfaceDerivatives DiscreteFace::derivatives(const Vec2& uv) {
  const Place p = decode(uv);
  return {evaluate(uv), corner(p, 1) - corner(p, 0), corner(p, 2) - corner(p, 0)};
}

Vec3 DiscreteFace::normal(const Vec2& uv) {
  const Place p = decode(uv);
  const Triangle& t = facets_.tri_to_vert[p.tri];
  const Vec3 facet = normalized(facet_normal(facets_.points, t));
  const Vec3 smooth = normalized(p.b0 * facets_.jets.normals[t[0]] + p.b1 * facets_.jets.normals[t[1]] +
                                 p.b2 * facets_.jets.normals[t[2]]);
  constexpr double kFarFromFacet = 0.7;  // cosine; where folds make the mean meaningless
  if (facet == Vec3{}) return smooth;
  return dot(smooth, facet) > kFarFromFacet ? smooth : facet;
}

PrincipalCurvatures DiscreteFace::curvature(const Vec2& uv) {
  const Place p = decode(uv);
  const Triangle& t = facets_.tri_to_vert[p.tri];
  const auto &m0 = facets_.jets.bending[t[0]], &m1 = facets_.jets.bending[t[1]], &m2 = facets_.jets.bending[t[2]];
  SymmetricTensor bending;
  for (std::size_t i = 0; i < bending.size(); ++i) bending[i] = p.b0 * m0[i] + p.b1 * m1[i] + p.b2 * m2[i];
  return principal_curvatures(bending, normal(uv));
}

SurfacePoint DiscreteFace::closest_point(const Vec3& x, const std::optional<Vec2>& guess) {
  FacetPoint start;
  Vec3 direction;
  if (guess) {
    const Place p = decode(*guess);
    start = {p.tri, closest_on_triangle(x, corner(p, 0), corner(p, 1), corner(p, 2))};
    direction = normal(*guess);
  }
  const FacetPoint found = facets_.bvh.closest_facing(x, direction, start);
  SurfacePoint result;
  result.uv = encode(found.tri, found.place.weights[1], found.place.weights[2]);
  result.point = evaluate(result.uv);
  result.distance = distance(result.point, x);
  return result;
}

Vec2 DiscreteFace::edge_parameters(const EdgeUse&, double) {
  throw Error(ErrorCode::Internal, "a facetted face has no parameter curves along its edges");
}

ParameterRange DiscreteFace::edge_range(const EdgeUse& use) { return {0, (*edge_lengths_)[use.edge.value]}; }

Tessellation DiscreteFace::tessellate(double, double) {
  Tessellation result;
  result.points = facets_.points;
  result.tri_to_vert = facets_.tri_to_vert;
  result.classification = facets_.vert_to_entity;
  result.edge_parameter = facets_.vert_to_parameter;
  for (std::uint32_t vert = 0; vert < result.points.size(); ++vert) {
    const std::uint32_t at = facets_.vert_to_corner[vert];
    result.uv.push_back(encode(at / 3, at % 3 == 1 ? 1 : 0, at % 3 == 2 ? 1 : 0));
  }
  return result;
}

}  // namespace tetloom::detail

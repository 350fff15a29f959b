#include "mesher/sizing/model_facets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "mesher/sizing/follow_face.hpp"
#include "mesher/sizing/narrow_entities.hpp"
#include "mesher/sizing/source_tree.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {
namespace {

bool is_sound(const Tessellation& facets) {
  if (facets.uv.size() != facets.points.size()) return false;
  if (!std::ranges::all_of(facets.points, [](const Vec3& p) { return is_finite(p); })) return false;
  return std::ranges::all_of(facets.tri_to_vert, [&](const auto& tri) {
    return std::ranges::all_of(tri, [&](std::uint32_t v) { return v < facets.points.size(); });
  });
}

// OpenCASCADE at times leaves facets across a face that is round, such as the half of a coil.
bool are_astray(const Tessellation& facets, double area) {
  constexpr double kMostLost = 0.1;
  return area > 0 && std::abs(area_of(facets) - area) > kMostLost * area;
}

Tessellation facet_face(const GeometricModel& model, ModelFaceId id, const FacetTolerance& tolerance, double area) {
  Tessellation facets;
  tolerate_bad_geometry([&] {
    const auto geometry = model.face_geometry(id);
    facets = geometry->tessellate(tolerance.chord, tolerance.angle);
    if (!is_sound(facets)) facets = {};
    if (geometry->parametrization() == Parametrization::Smooth && are_astray(facets, area))
      follow_face(*geometry, id, tolerance.chord, facets);
  });
  return facets;
}

void put_facets(MessageWriter& writer, const Tessellation& facets) {
  writer.put_array(std::span<const Vec3>(facets.points));
  writer.put_array(std::span<const Vec2>(facets.uv));
  writer.put_array(std::span<const std::array<std::uint32_t, 3>>(facets.tri_to_vert));
  writer.put_array(std::span<const ModelEntity>(facets.classification));
  writer.put_array(std::span<const double>(facets.edge_parameter));
}

Tessellation get_facets(MessageReader& reader) {
  Tessellation facets;
  facets.points = reader.get_array<Vec3>();
  facets.uv = reader.get_array<Vec2>();
  facets.tri_to_vert = reader.get_array<std::array<std::uint32_t, 3>>();
  facets.classification = reader.get_array<ModelEntity>();
  facets.edge_parameter = reader.get_array<double>();
  return facets;
}

/// Distance along the ray to the triangle, or infinity (Möller & Trumbore 1997).
double ray_distance(const Vec3& origin, const Vec3& direction, const Vec3& a, const Vec3& ab, const Vec3& ac) {
  const Vec3 p = cross(direction, ac);
  const double det = dot(ab, p);
  if (det == 0) return HUGE_VAL;
  const Vec3 s = origin - a;
  const double u = dot(s, p) / det;
  if (!(u >= 0 && u <= 1)) return HUGE_VAL;
  const Vec3 q = cross(s, ab);
  const double v = dot(direction, q) / det;
  if (!(v >= 0 && u + v <= 1)) return HUGE_VAL;
  return dot(ac, q) / det;
}

/// Whether the ray meets the box before `to`.
bool meets(const Box3& box, const Vec3& origin, const Vec3& inverse, double to) {
  double enter = 0, leave = to;
  for (int axis = 0; axis < 3; ++axis) {
    const double t0 = (box.lo[axis] - origin[axis]) * inverse[axis];
    const double t1 = (box.hi[axis] - origin[axis]) * inverse[axis];
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  return enter <= leave * (1 + 1e-12);
}

/// Whether a triangle meets the cube [-half, half]³: no plane along a face of the cube, along the triangle, or along an
/// edge of each parts them (Akenine-Möller 2001).
bool meets_cube(const std::array<Vec3, 3>& triangle, double half) {
  const auto parts = [&](const Vec3& axis) {
    const double a = dot(axis, triangle[0]), b = dot(axis, triangle[1]), c = dot(axis, triangle[2]);
    const double reach = half * (std::abs(axis.x) + std::abs(axis.y) + std::abs(axis.z));
    return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
  };
  const Vec3 ab = triangle[1] - triangle[0], bc = triangle[2] - triangle[1], ca = triangle[0] - triangle[2];
  if (parts({1, 0, 0}) || parts({0, 1, 0}) || parts({0, 0, 1}) || parts(cross(ab, bc))) return false;
  for (const Vec3& edge : {ab, bc, ca})
    if (parts({0, -edge.z, edge.y}) || parts({edge.z, 0, -edge.x}) || parts({-edge.y, edge.x, 0})) return false;
  return true;
}

}  // namespace

std::vector<Tessellation> facet_faces(const GeometricModel& model, const std::vector<FacetTolerance>& tolerances,
                                      const SharedWork& work) {
  std::vector<Tessellation> faces(model.topology().face_count());
  std::vector<double> areas(faces.size(), 0.0);
  for (std::size_t f = 0; f < faces.size(); ++f) areas[f] = model.area(ModelFaceId(f));
  work.for_each(areas, {[&](std::size_t f) { faces[f] = facet_face(model, ModelFaceId(f), tolerances[f], areas[f]); },
                        [&](std::size_t f, MessageWriter& writer) { put_facets(writer, faces[f]); },
                        [&](std::size_t f, MessageReader& reader) { faces[f] = get_facets(reader); }});
  return faces;
}

FacetTree::FacetTree(const GeometricModel& model, const std::vector<Tessellation>& faces, const TaskRunner& runner)
    : model_(model) {
  std::vector<std::size_t> first{0};
  for (const Tessellation& face : faces) {
    complete_ = complete_ && !face.tri_to_vert.empty();
    first.push_back(first.back() + face.tri_to_vert.size());
  }
  std::vector<Facet> facets(first.back());
  std::vector<Box3> boxes(first.back());
  constexpr std::size_t kBlock = 4096;
  runner.for_blocks(facets.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    std::size_t f = static_cast<std::size_t>(std::ranges::upper_bound(first, begin) - first.begin()) - 1;
    for (std::size_t i = begin; i < end; ++i) {
      while (i >= first[f + 1]) ++f;
      const auto& [a, b, c] = faces[f].tri_to_vert[i - first[f]];
      const std::vector<Vec3>& p = faces[f].points;
      facets[i] = {p[a], p[b], p[c], static_cast<std::uint32_t>(f)};
      for (const std::uint32_t v : {a, b, c}) boxes[i].add(p[v]);
    }
  });
  bvh_ = build_bvh(boxes, runner);
  facets_.resize(facets.size());
  runner.for_blocks(facets.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) facets_[i] = facets[bvh_.order[i]];
  });
}

std::optional<FacetHit> FacetTree::first_hit(const Vec3& origin, const Vec3& direction, double from, double to) const {
  if (bvh_.nodes.empty()) return std::nullopt;
  // A zero component would make 0 * infinity at a box that touches the ray.
  const auto invert = [](double d) { return 1 / (std::abs(d) > 1e-300 ? d : 1e-300); };
  const Vec3 inverse{invert(direction.x), invert(direction.y), invert(direction.z)};
  const Facet* nearest = nullptr;
  double best = to;
  std::array<std::uint32_t, 64> stack;
  std::size_t count = 0;
  stack[count++] = 0;
  while (count > 0) {
    const std::uint32_t index = stack[--count];
    const BvhNode& node = bvh_.nodes[index];
    if (!meets(node.box, origin, inverse, best)) continue;
    if (node.right != 0) {
      stack[count++] = node.right;
      stack[count++] = index + 1;
      continue;
    }
    for (std::uint32_t i = node.begin; i < node.end; ++i) {
      const Facet& facet = facets_[i];
      const double t = ray_distance(origin, direction, facet.a, facet.b - facet.a, facet.c - facet.a);
      if (t > from && t < best) best = t, nearest = &facet;
    }
  }
  if (nearest == nullptr) return std::nullopt;
  const Vec3 normal = normalized(cross(nearest->b - nearest->a, nearest->c - nearest->a));
  const FaceSides& sides = model_.topology().face_to_sides[nearest->face];
  return FacetHit{nearest->face, best, normal, dot(direction, normal) > 0 ? sides.back : sides.front};
}

bool FacetTree::any_in(const Vec3& center, double half_width) const {
  if (bvh_.nodes.empty()) return false;
  const Vec3 half{half_width, half_width, half_width};
  const Box3 cube{center - half, center + half};
  std::array<std::uint32_t, 64> stack;
  std::size_t count = 0;
  stack[count++] = 0;
  while (count > 0) {
    const std::uint32_t index = stack[--count];
    const BvhNode& node = bvh_.nodes[index];
    if (!node.box.overlaps(cube)) continue;
    if (node.right != 0) {
      stack[count++] = node.right;
      stack[count++] = index + 1;
      continue;
    }
    for (std::uint32_t i = node.begin; i < node.end; ++i) {
      const Facet& facet = facets_[i];
      if (meets_cube({facet.a - center, facet.b - center, facet.c - center}, half_width)) return true;
    }
  }
  return false;
}

ModelRegionId FacetTree::region_at(const Vec3& x) const {
  constexpr std::array<Vec3, 5> kDirections{{{0.3561, 0.8102, 0.4655},
                                             {-0.7713, 0.2279, 0.5943},
                                             {0.2846, -0.5107, 0.8113},
                                             {0.6217, 0.3391, -0.7060},
                                             {-0.4129, -0.6947, -0.5891}}};
  std::array<ModelRegionId, kDirections.size()> votes;
  for (std::size_t i = 0; i < kDirections.size(); ++i) {
    const std::optional<FacetHit> hit = first_hit(x, normalized(kDirections[i]), 0, HUGE_VAL);
    if (hit) votes[i] = hit->near_region;
    const auto agreeing = std::count(votes.begin(), votes.begin() + static_cast<std::ptrdiff_t>(i + 1), votes[i]);
    if (agreeing == 2) return votes[i];
  }
  return votes[0];
}

}  // namespace tetloom

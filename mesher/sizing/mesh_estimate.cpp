#include "mesher/sizing/mesh_estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mesher/sizing/model_facets.hpp"
#include "mesher/sizing/size_targets.hpp"
#include "mesher/volume/volume_mesher.hpp"

namespace tetloom {
namespace {

MeshEstimate with_bytes(double triangles, double tets) {
  constexpr double kBytesPerTriangle = 800, kBytesPerTet = 65;  // 54 to 69 measured from 5 to 322 million tets
  return {triangles, tets, kBytesPerTriangle * triangles + kBytesPerTet * tets};
}

double square(double x) { return x * x; }
double cube(double x) { return x * x * x; }

/// The mean of 1/size² over a triangle, cut into four while its edges are much longer than the sizes in it.
double mean_density(const SizeField& sizes, const Vec3& a, const Vec3& b, const Vec3& c, int depth) {
  const double longest = std::sqrt(std::max({norm2(b - a), norm2(c - b), norm2(a - c)}));
  double sum = 0, smallest = HUGE_VAL, largest = 0;
  for (const Vec3& w : {Vec3{1, 1, 1} / 3, Vec3{0.6, 0.2, 0.2}, Vec3{0.2, 0.6, 0.2}, Vec3{0.2, 0.2, 0.6}}) {
    const double size = sizes.size_at(w.x * a + w.y * b + w.z * c);
    sum += 1 / square(size);
    smallest = std::min(smallest, size);
    largest = std::max(largest, size);
  }
  const bool varies = largest > 1.2 * smallest || longest > 8 * smallest;
  if (depth == 0 || !varies || longest < 2 * smallest) return sum / 4;
  const Vec3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
  return (mean_density(sizes, a, ab, ca, depth - 1) + mean_density(sizes, ab, b, bc, depth - 1) +
          mean_density(sizes, ca, bc, c, depth - 1) + mean_density(sizes, ab, bc, ca, depth - 1)) /
         4;
}

double triangles_of(const Tessellation& facets, const SizeField& sizes, double area) {
  double weighted = 0, facet_area = 0;
  for (const auto& tri : facets.tri_to_vert) {
    const Vec3 &a = facets.points[tri[0]], &b = facets.points[tri[1]], &c = facets.points[tri[2]];
    const double share = 0.5 * norm(cross(b - a, c - a));
    facet_area += share;
    weighted += share * mean_density(sizes, a, b, c, 5);
  }
  if (!(facet_area > 0)) return area * kTrianglesPerSquare / square(sizes.largest());
  return area / facet_area * weighted * kTrianglesPerSquare;
}

/// Which share of the tetrahedra that would fill the model's box lies inside its regions: systematic samples of the
/// octree's leaves, spaced evenly by the number of tetrahedra, so that fine leaves are seen as they count.
double inside_share(const FacetTree& facets, const SizeField& sizes, const Box3& box, double total,
                    const SharedWork& work) {
  constexpr std::size_t kSamples = 8192;
  std::vector<Vec3> samples;
  double sum = 0;
  sizes.for_each_leaf(box, [&](const SizeLeaf& leaf) {
    const Vec3 extent = leaf.box.hi - leaf.box.lo;
    const double before = sum;
    sum += extent.x * extent.y * extent.z * kTetsPerCube / cube(leaf.size);
    const auto rank = [&](double amount) { return static_cast<std::size_t>(amount / total * kSamples + 0.5); };
    for (std::size_t i = rank(before); i < rank(sum); ++i) {
      // An additive recurrence with irrational steps spreads several samples of one leaf over it (Roberts 2018).
      const double n = static_cast<double>(i);
      const auto fraction = [](double x) { return x - std::floor(x); };
      samples.push_back(leaf.box.lo + Vec3{extent.x * fraction(0.5 + 0.8191725133961645 * n),
                                           extent.y * fraction(0.5 + 0.6710436067037893 * n),
                                           extent.z * fraction(0.5 + 0.5497004779019703 * n)});
    }
  });
  if (samples.empty()) return 0;
  std::vector<std::uint8_t> inside(samples.size());
  work.fill<std::uint8_t>(inside, 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) inside[i] = facets.region_at(samples[i]).valid() ? 1 : 0;
  });
  return static_cast<double>(std::ranges::count(inside, 1)) / static_cast<double>(samples.size());
}

double total_volume(const GeometricModel& model) {
  double volume = 0;
  for (std::size_t r = 0; r < model.topology().region_count(); ++r) volume += std::abs(model.volume(ModelRegionId(r)));
  return volume;
}

MeshEstimate estimate_uniform(const GeometricModel& model, double size) {
  double area = 0;
  for (std::size_t f = 0; f < model.topology().face_count(); ++f) area += model.area(ModelFaceId(f));
  return with_bytes(area * kTrianglesPerSquare / square(size), total_volume(model) * kTetsPerCube / cube(size));
}

}  // namespace

MeshEstimate estimate_mesh(const GeometricModel& model, const SizeField& sizes, const SharedWork& work) {
  if (sizes.is_uniform()) return estimate_uniform(model, sizes.largest());
  const std::vector<FacetTolerance> tolerances(model.topology().face_count(), {0.2 * sizes.largest(), 0.5});
  const std::vector<Tessellation> facets = facet_faces(model, tolerances, work);
  return estimate_mesh(model, sizes, facets, FacetTree(model, facets, work.runner()), work);
}

MeshEstimate estimate_mesh(const GeometricModel& model, const SizeField& sizes, const std::vector<Tessellation>& facets,
                           const FacetTree& tree, const SharedWork& work) {
  if (sizes.is_uniform()) return estimate_uniform(model, sizes.largest());
  std::vector<double> triangles(facets.size());
  std::vector<double> amounts;
  for (const Tessellation& face : facets) amounts.push_back(static_cast<double>(face.tri_to_vert.size()));
  work.for_each(amounts,
                {[&](std::size_t f) { triangles[f] = triangles_of(facets[f], sizes, model.area(ModelFaceId(f))); },
                 [&](std::size_t f, MessageWriter& writer) { writer.put(triangles[f]); },
                 [&](std::size_t f, MessageReader& reader) { triangles[f] = reader.get<double>(); }});
  double triangle_count = 0;
  for (const double count : triangles) triangle_count += count;
  if (model.topology().region_count() == 0) return with_bytes(triangle_count, 0);
  const double in_box = sizes.estimate_tets(model.bounding_box());
  const double share = inside_share(tree, sizes, model.bounding_box(), in_box, work);
  const double at_least = total_volume(model) * kTetsPerCube / cube(sizes.largest());
  return with_bytes(triangle_count, std::max(share * in_box, at_least));
}

MeshEstimate estimate_least_mesh(const GeometricModel& model, const SizeOptions& options) {
  const SizeTargets targets = resolve_sizes(model, options);
  double triangles = 0, tets = 0;
  for (std::size_t f = 0; f < targets.face.size(); ++f)
    triangles += model.area(ModelFaceId(f)) * kTrianglesPerSquare / square(std::min(targets.face[f], targets.global));
  for (std::size_t r = 0; r < targets.region.size(); ++r)
    tets += std::abs(model.volume(ModelRegionId(r))) * kTetsPerCube / cube(std::min(targets.region[r], targets.global));
  return with_bytes(triangles, tets);
}

MeshEstimate estimate_filling(const VolumeInput& input) {
  Box3 box;
  double volume = 0;  // of all regions, by cones from a point of the surface
  for (std::size_t t = 0; t < input.tri_to_vert.size(); ++t) {
    const FaceSides& sides = input.tri_to_sides[t];
    const auto& [a, b, c] = input.tri_to_vert[t];
    for (const std::uint32_t v : {a, b, c}) box.add(input.points[v]);
    const Vec3& apex = input.points[input.tri_to_vert[0][0]];
    const Vec3 p = input.points[a] - apex, q = input.points[b] - apex, r = input.points[c] - apex;
    volume += dot(cross(p, q), r) / 6 * (int{sides.back.valid()} - int{sides.front.valid()});
  }
  if (box.empty()) return {};
  const Vec3 extent = box.hi - box.lo;
  const double box_volume = extent.x * extent.y * extent.z;
  const double share = box_volume > 0 ? std::clamp(std::abs(volume) / box_volume, 0.0, 1.0) : 0;
  const auto triangles = static_cast<double>(input.tri_to_vert.size());
  return with_bytes(triangles, std::max(share * input.sizes->estimate_tets(box), triangles));
}

double count_elements(const MeshEstimate& estimate) {
  constexpr double kTetsPerTriangleOfWalls = 1.5;
  return std::max(estimate.tets, kTetsPerTriangleOfWalls * estimate.triangles);
}

MeshEstimate surface_part(const MeshEstimate& estimate) { return with_bytes(estimate.triangles, 0); }

}  // namespace tetloom

#pragma once
// Normals and curvatures of a facetted surface at its points. Private to core/discrete.
#include <array>
#include <span>
#include <vector>

#include "core/discrete/facet_soup.hpp"
#include "tetloom/model.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::detail {

/// A symmetric 3×3 matrix: xx, xy, xz, yy, yz, zz.
using SymmetricTensor = std::array<double, 6>;

/// Unit normals, the mean of the facets' normals weighted by their angle at the point; zero where they cancel.
std::vector<Vec3> compute_vertex_normals(std::span<const Vec3> points, std::span<const Triangle> tri_to_vert);

/// What the surface does at a point: unit normal, and the second fundamental form as a tensor in space that vanishes
/// along the normal, with the sign of PrincipalCurvatures (negative where the surface bends away from its normal, as a
/// sphere with outward normals does).
struct PointJets {
  std::vector<Vec3> normals;
  std::vector<SymmetricTensor> bending;
};

/// Fits a quadric to the neighbours of each point, in the frame of its mean normal: a jet of degree 2 (Cazals & Pouget
/// 2003) with least squares weighted by 1/distance². We hold the point itself fixed, take the second ring of neighbours
/// only where the first has fewer than six points or the point lies on the rim, and leave at zero what the neighbours
/// do not tell. Bending that noise of the points makes, to and fro from one point to the next, is averaged out. The jet
/// also corrects the normal, which at a rim would else be that of the facets on one side.
PointJets fit_jets(std::span<const Vec3> points, std::span<const Triangle> tri_to_vert,
                   const std::vector<bool>& on_rim);

/// The eigenvalues of a bending tensor in the plane across `normal`. Zero for a zero normal.
PrincipalCurvatures principal_curvatures(const SymmetricTensor& bending, const Vec3& normal);

}  // namespace tetloom::detail

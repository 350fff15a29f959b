#pragma once
// Triangle surfaces that the families of facets are made of.
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/families/family.hpp"
#include "tests/support/families/random.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::test {

struct FacetSurface {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from outside
};

/// Signed; of a closed surface.
double enclosed_volume(const FacetSurface& surface);

/// Where `field` changes its sign, inside of [0, 1]³, over a grid of `cells` cubes each way, each cut into six tets
/// along its diagonal (Doi & Koide 1991, "An efficient method of triangulating equi-valued surfaces by using
/// tetrahedral cells"). Inside is where it is positive. Closed and manifold where the field is negative on the box.
FacetSurface march(const std::function<double(const Vec3&)>& field, int cells);

/// Some balls that flow into each other, scaled to about the size 20.
FacetSurface random_blob(Random& random, int cells);

/// Writes `surface` as a file of facets: binary or text STL, or OBJ. `model` has the volume and how many solids there
/// are already.
void write_facets(const FacetSurface& surface, Random& random, const std::filesystem::path& folder, FamilyModel& model);

}  // namespace tetloom::test

#pragma once
// The surface cut into complexes: regions connected through common triangles, to be filled together.
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/model.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::volume {

/// A part of the surface with numbers of its own. Its points are those of its triangles, in ascending order. Refers to
/// arrays of the input, or to those of a ComplexArrays.
struct Complex {
  std::vector<std::uint32_t> regions;  ///< ascending
  std::span<const std::uint32_t> to_input_tri, to_input_vert;
  std::span<const Vec3> points;
  std::span<const std::array<std::uint32_t, 3>> tri_to_vert;  ///< into `points`
  std::span<const FaceSides> tri_to_sides;
};

/// What a complex refers to where it is not all of the input.
struct ComplexArrays {
  std::vector<std::uint32_t> to_input_tri, to_input_vert;
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> tri_to_vert;
  std::vector<FaceSides> tri_to_sides;

  /// Pre: the arrays are complete.
  Complex view(std::vector<std::uint32_t> regions) const {
    return {std::move(regions), to_input_tri, to_input_vert, points, tri_to_vert, tri_to_sides};
  }
};

/// All of a surface, with their arrays.
struct Complexes {
  std::vector<ComplexArrays> arrays;  ///< one each; empty where the input's will do
  std::vector<Complex> list;
};

/// Regions whose boundary does not close, one diagnostic each (code OpenShell; the faces at the open edges, a point on
/// one of them, the triangles), in ascending order of the region in `regions`.
/// A boundary closes when each of its directed edges, with the region always on the same side of the triangle, is run
/// through as often one way as the other.
struct OpenRegions {
  std::vector<std::uint32_t> regions;
  std::vector<Diagnostic> diagnostics;
};
OpenRegions find_open_regions(const VolumeInput& input, const SharedWork& work);
/// How many pieces that is done in, about.
std::size_t open_region_pieces(const VolumeInput& input);

/// The complexes in ascending order of their first region. Triangles that bound no region, or only regions of
/// `without`, are in none; the sides of the others forget the regions of `without`.
Complexes split_complexes(const VolumeInput& input, std::span<const std::uint32_t> without);

/// A model face or region with its name where there is a model.
NamedEntity named_entity(const VolumeInput& input, ModelEntity entity);

/// The model faces of some input triangles, each once, those with most triangles first.
std::vector<NamedEntity> faces_of(const VolumeInput& input, std::span<const std::uint32_t> triangles);

/// "region 3 'shaft'", or "regions 3 'shaft', 4, … (7 in all)".
std::string describe_regions(const VolumeInput& input, std::span<const std::uint32_t> regions);

}  // namespace tetloom::volume

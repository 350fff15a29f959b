#pragma once
// How good a mesh is: shapes of its elements, and how well its edges keep to the sizes asked for.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/block_loop.hpp"
#include "core/mesh/cell_shape.hpp"
#include "core/mesh/mesh.hpp"
#include "core/sizing/size_field.hpp"

namespace tetloom {

/// Edge lengths divided by the size asked for; every unique edge counts once. Zeros where no size field was given.
struct EdgeConformity {
  std::size_t edges = 0;         ///< unique edges of the elements
  double mean_length = 0;        ///< model length
  double mean_length_ratio = 0;  ///< mean of length / size; the size is the mean of those at the edge's ends
  double in_band = 0;            ///< share of edges with length / size in [0.707106781, 1.41421356]
};

struct RegionQuality {
  std::uint32_t region = 0;  ///< index of the model region; Id::kNone for unclassified cells
  std::size_t tets = 0;
  std::size_t cells = 0;  ///< of all kinds, tets as well
  double volume = 0;      ///< of all of them
};

/// Cells of all kinds together.
struct CellQuality {
  std::array<std::size_t, kCellKinds> counts{};  ///< by CellKind
  std::size_t count = 0;                         ///< of all kinds
  std::size_t inverted = 0;                      ///< cells that are not positive at all corners (exact sign)
  double volume = 0;                             ///< sum of signed volumes; faces of four points are bilinear
  std::vector<RegionQuality> regions;            ///< ascending by region
};

struct TetQuality {
  std::size_t count = 0;
  std::size_t inverted = 0;     ///< tets whose exact volume is not positive
  double min_dihedral_deg = 0;  ///< smallest angle between two faces of a tet; 0 as soon as one tet is inverted
  double mean_ratio_min = 0;    ///< mean ratio: 12 (3V)^(2/3) / sum of squared edges; 1 regular, 0 flat or inverted
  double mean_ratio_p1 = 0;     ///< first percentile, interpolated linearly
  double mean_ratio_mean = 0;
  double volume = 0;                                   ///< sum of signed volumes of the tets alone
  std::array<std::size_t, 10> mean_ratio_histogram{};  ///< bins of width 0.1; 1 falls into the last
  std::array<std::size_t, 18>
      dihedral_histogram{};  ///< six angles of every tet that is not inverted, bins of 10 degrees
  EdgeConformity edges;
};

struct FaceQuality {
  std::uint32_t face = 0;  ///< index of the model face; Id::kNone for unclassified triangles
  std::size_t triangles = 0;
  double area = 0;
  double min_angle_deg = 0;
};

struct TriangleQuality {
  std::size_t count = 0;
  double shape_min = 0;  ///< 4 sqrt(3) A / sum of squared edges; 1 equilateral, 0 flat
  double shape_p1 = 0;   ///< first percentile, interpolated linearly
  double shape_mean = 0;
  double min_angle_deg = 0;  ///< smallest corner angle
  double area = 0;
  EdgeConformity edges;
  std::vector<FaceQuality> faces;  ///< ascending by face
};

/// All fields of a kind of element that the mesh does not have are zero.
struct QualityReport {
  CellQuality cells;
  TetQuality tets;
  TriangleQuality triangles;
};

/// Measures `mesh`: shapes and edges of tets and triangles, and how many cells of any kind there are and how much space
/// they fill. `sizes` may be null: then only lengths are measured, not their ratio to a size.
/// Pre: indices lie in range and arrays have matching lengths (see `validate_mesh`); orientation and classification
/// may be anything. Throws Error(InvalidArgument) otherwise.
/// Complexity: linear; one size query per point; about 4 bytes per tet, 8 per point and 128 MiB of working memory.
/// `loop` carries out the work; no bit of the result depends on it. Thread safety: may be called from any thread.
QualityReport compute_quality(const Mesh& mesh, const SizeField* sizes = nullptr,
                              const BlockLoop& loop = serial_loop());

}  // namespace tetloom

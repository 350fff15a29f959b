#pragma once
// What a lattice is made of: the sites of one cube, which of them are next to each other, and the tetrahedra between.
//
// Body-centred cubic: 2 sites and 12 tets per cube, all alike, of mean ratio .952.
// A15 (Frank & Kasper 1959): 8 sites and 46 tets per cube, of mean ratios .945, .975 and .991, .977 on average. The
// sites are the corners and the centre of the cube (o) and two on every face, which form straight rows (a, b, c):
//
//       z = 0         z = 1/4       z = 1/2       z = 3/4
//     o-------o     +-------+     +-a---a-+     +-------+
//     |   c   |     |       |     |       |     |       |
//     |       |     b       b     |   o   |     b       b
//     |   c   |     |       |     |       |     |       |
//     o-------o     +-------+     +-a---a-+     +-------+
//
// In both, four sites that are all next to each other are a Delaunay tetrahedron, and there are no others.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tetloom/filling.hpp"

namespace tetloom::lattice {

/// A point of a lattice: its coordinates in halves (body-centred) or quarters (A15) of a cube.
struct Site {
  std::int32_t i, j, k;
  friend constexpr auto operator<=>(const Site&, const Site&) = default;
};

/// A site of a cube's neighbourhood: which one of a cube, and how many cubes away that is.
struct SiteStep {
  int kind, x, y, z;
};

/// A tet that is the same in every cube. Its vertices make it positive; its first one lies in the cube itself.
struct TetType {
  struct Behind {
    int type, face, x, y, z;  ///< through which face of which type, and how many cubes away that is
  };
  std::array<SiteStep, 4> verts;
  std::array<Behind, 4> behind;
};

/// Immutable; any thread may read it.
class LatticeShape {
 public:
  /// The sites of a row of the lattice: at i = first + n · step; none when step is 0.
  struct Row {
    std::int32_t first = 0, step = 0;
  };

  static const LatticeShape& of(LatticeKind lattice);

  int parts() const { return parts_; }  ///< of a cube that sites are given in: 2 or 4
  /// Widths of cubes, in sizes: with one size, and with several.
  double cube_per_size() const { return cube_per_size_; }
  double graded_cube_per_size() const { return graded_cube_per_size_; }
  /// How near to the surface a site is dropped, in sizes of its lattice: sites next to each other are less than twice
  /// as far apart.
  double from_surface() const { return from_surface_; }
  /// How near to the surface a site counts as near: more than twice the radius of a circumsphere.
  double near_surface() const { return near_surface_; }
  /// How far triangles are measured. Where every place on a face of a tet is within from_surface() of a site, no
  /// triangle passes between sites that are kept, so that farther off the surface's points are enough; else
  /// near_surface().
  double triangle_reach() const { return triangle_reach_; }

  /// Sites of the cube at 0, by kind.
  const std::vector<Site>& sites() const { return sites_; }
  int kind_of(const Site& site) const { return residue_to_kind_[residue(site.i, site.j, site.k)]; }
  /// The row at (j, k) is rows()[(k & mask) · parts + (j & mask)], where mask is parts - 1.
  const Row* rows() const { return rows_.data(); }
  /// Steps from a site of a kind to those next to it.
  const std::vector<Site>& around(int kind) const { return around_[static_cast<std::size_t>(kind)]; }
  const std::vector<TetType>& tets() const { return tets_; }

  /// The site `from` + `step`, seen from the cube of `from`. Pre: `from` lies in the cube at 0.
  SiteStep step_to(const Site& from, const Site& step) const;

 private:
  explicit LatticeShape(LatticeKind lattice);
  void set_bcc();
  void set_a15();
  void find_around();
  void find_tets();
  void add_tets_at(const Site& first);
  void find_behind();
  bool is_next(const Site& a, const Site& b) const;
  TetType make_type(std::array<Site, 4> verts) const;
  std::size_t residue(std::int32_t i, std::int32_t j, std::int32_t k) const {
    const std::int32_t mask = parts_ - 1;
    return static_cast<std::size_t>(((k & mask) * parts_ + (j & mask)) * parts_ + (i & mask));
  }

  int parts_ = 0, nearest_ = 0, farthest_ = 0;  // squared distances between sites next to each other
  double cube_per_size_ = 0, graded_cube_per_size_ = 0, from_surface_ = 0, near_surface_ = 0, triangle_reach_ = 0;
  std::vector<Site> sites_;
  std::vector<int> residue_to_kind_;  // -1: no site
  std::vector<Row> rows_;
  std::vector<std::vector<Site>> around_;
  std::vector<TetType> tets_;
};

}  // namespace tetloom::lattice

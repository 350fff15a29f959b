#pragma once
// The sites of one lattice in one box, how far each is from the surface, and which lie on the same side of it.
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "mesher/intersection/triangle_tree.hpp"
#include "mesher/lattice/site_lattice.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::lattice {

/// A site inside of the surface.
struct KeptSite {
  Site site;
  bool near_surface;
};

/// Finds the sites of `lattice` in the half-open box that are wanted, far enough from the triangles of `tree` and
/// inside, by k, then j, then i.
///
/// Two sites next to each other that are both far enough from the surface lie on the same side of it: what lies between
/// them is nearer to one of them than the surface. So `is_inside` is asked once for each connected group.
class CellSites {
 public:
  struct Questions {
    const intersection::TriangleTree* tree = nullptr;  ///< nullptr: no surface near the box
    std::function<bool(const Vec3&)> is_wanted;        ///< empty: all are
    std::function<bool(const Vec3&)> is_inside;        ///< empty: all are
  };

  std::vector<KeptSite> find(const SiteLattice& lattice, const Box3& box, const Questions& questions);

 private:
  struct Entry {
    Vec3 point;
    std::uint32_t group;  // none for what is no site, is not wanted or lies too near to the surface
    bool near;            // to a point of the surface, or to a triangle as far as these are measured
  };

  void enter_sites(const Questions& questions);
  void measure_distances(const intersection::TriangleTree& tree);
  void measure_to(const std::array<Vec3, 3>& triangle);
  void mark_near(const Vec3& surface_point);
  template <class Visit>
  void for_each_wanted_in(const Box3& box, Visit&& visit);
  void group_sites();
  void spread_group(const Site& seed, std::uint32_t group);
  std::vector<KeptSite> take_inside(const Questions& questions) const;
  std::size_t slot_of(const Site& site) const;
  bool holds(const Site& site) const;

  const SiteLattice* lattice_ = nullptr;
  Site first_{}, end_{}, wanted_first_{}, wanted_end_{};
  double reach2_ = 0, nearest2_ = 0;          // to triangles, squared: how far is measured, how near is too near
  std::size_t columns_ = 0, rows_ = 0;        // of sites, along i and j
  std::vector<Entry> entries_;                // of all sites between first_ and end_, by k, j, i
  std::vector<Site> stack_, heads_;           // heads_: one site per group
  std::vector<std::uint32_t> point_to_cell_;  // the last cell whose sites it has marked, by its number
  std::uint32_t cell_ = 0;
};

}  // namespace tetloom::lattice

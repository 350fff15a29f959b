#pragma once
// Puts a point into a poor tet: often one whose vertices cannot move, as they lie on the surface.
//
// The cavity starts as the tets around one edge, or as the tet alone; the point is led to where the star of the
// cavity's boundary is best, and as long as the worst of the star gets better, the tet behind it joins the cavity.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/tets/star_tet.hpp"
#include "core/tets/vertex_star.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

/// Holds the room that one insertion needs.
class PointInserter {
 public:
  /// Tets of cubed quality below `limit` count as poor.
  PointInserter(WorkingMesh& mesh, double limit) : mesh_(mesh), limit_(limit) {}

  /// Inserts the best point found for `tet`, if that raises the minimum of the cavity and leaves fewer poor tets, or as
  /// many of which the worst is much better; more poor tets only where the worst is twice as good in cubed quality, or
  /// much better where it was next to flat, as between the six points of a prism whose sides are cut by diagonals that
  /// run around it. New tets are positive in exact arithmetic. False, and nothing changes, when there is no such
  /// point.
  bool insert(std::uint32_t tet);

 private:
  struct Facet {
    std::array<std::uint32_t, 3> verts;  // counter-clockwise from inside
    FaceCode behind;                     // not valid where the cavity must end
  };
  struct Cavity {
    std::size_t tet_count = 0, facet_count = 0;
    int poor_before = 0, gain = 0;  // poor tets before, and how many fewer after
    double least_before = 0, least = 0;
    Vec3 point;
    std::array<std::uint32_t, WorkingMesh::kMostTets> tets;
    std::array<Facet, WorkingMesh::kMostTets> facets;

    std::span<const std::uint32_t> old() const { return {tets.data(), tet_count}; }
  };

  void try_cavity(std::span<const std::uint32_t> tets, const Vec3& point);
  bool set_cavity(std::span<const std::uint32_t> tets);
  bool add_tet(std::uint32_t tet);
  Vec3 middle() const;  // of the cavity's boundary
  bool lead_point();
  bool go_deep();
  bool place_point(const Vec3& point);
  int count_poor() const;
  void measure();
  std::size_t worst_facet() const;

  WorkingMesh& mesh_;
  double limit_;
  Cavity now_, kept_, best_;
  std::array<StarTet, WorkingMesh::kMostTets> star_;
};

/// PointInserter::insert for the tets of cubed quality below `limit`, in order of ids. Returns the number of points.
std::size_t insert_points(WorkingMesh& mesh, double limit, const TaskRunner& runner);

}  // namespace tetloom::tets

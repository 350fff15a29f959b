#pragma once
// Other tets in place of one that cannot be valid with its mid nodes on the model: one with two faces on one smooth
// surface, say, between which the Jacobian is 0.
//
//        c                 On the exact surface the faces abc and abd have one tangent plane along ab. Where the inner
//      / | \     .         edge cd is removed, or a point put behind it, each of them has a tet of its own.
//     a--|--b      x
//      \ | /     .
//        d
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/tets/deep_point.hpp"
#include "core/tets/star_tet.hpp"
#include "core/tets/vertex_star.hpp"
#include "core/tets/working_mesh.hpp"
#include "mesher/second_order/curved_judge.hpp"

namespace tetloom::second_order {

/// Works on one patch, whose surface and hull stay.
class PatchMender {
 public:
  /// New tets have a cubed quality above `floor`. Pre: `judge` judges tets between the points of `mesh`.
  PatchMender(tets::TetMesh& mesh, const CurvedJudge& judge, double floor)
      : mesh_(mesh, 0), judge_(judge), floor_(floor), probe_(mesh_.add_point({})) {}

  /// Removes an inner edge of `tet` or puts a point into a cavity around it, whichever leaves the best worst tet. All
  /// new tets are good. False, and nothing changes, where there is no such way.
  bool mend(std::uint32_t tet);

  /// Moves the free vertices of the tets made so far by Newton steps of their quality; all stay good.
  void smooth();

  bool is_good(std::uint32_t tet) const { return judge_.is_good(verts_of(tet)); }
  bool is_dead(std::uint32_t tet) const { return mesh_.mesh().is_dead(tet); }

  /// The points of the mesh from its end on that are no vertices: always one.
  static constexpr std::size_t kUnusedPoints = 1;

 private:
  struct Facet {
    std::array<std::uint32_t, 3> verts;  // counter-clockwise from inside
    tets::FaceCode behind;               // not valid where the cavity must end
  };
  struct Cavity {
    std::vector<std::uint32_t> tets;
    std::vector<Facet> facets;
  };
  struct Change {
    std::vector<std::uint32_t> old;
    std::vector<tets::NewTet> made;
    Vec3 point;  // of the probe
    bool has_point = false;
    double value = 0;  // the least cubed quality
  };

  CurvedJudge::Verts verts_of(std::uint32_t tet) const;
  void try_removal(const tets::EdgeRing& ring);
  void try_cavity(std::span<const std::uint32_t> tets);
  bool add_tet(std::uint32_t tet);
  Vec3 middle() const;
  bool go_deep(Vec3& point);
  void add_functions(const Facet& facet, const Vec3& point, double step);
  Change lead(Vec3 point);
  Change fan_at(const Vec3& point);
  Vec3 step_at(const Vec3& point);
  std::size_t worst_facet(const Change& change) const;
  void keep_better(Change&& change);
  void apply();
  bool smooth(std::uint32_t tet, std::uint32_t corner);

  tets::WorkingMesh mesh_;
  const CurvedJudge& judge_;
  double floor_;
  std::uint32_t probe_;  // the last point: where the next one might be
  Cavity cavity_;
  Change best_;
  std::vector<tets::AffineFunction> functions_;
  std::vector<tets::StarTet> star_;
  std::vector<std::uint32_t> made_verts_;  // of tets made, in any order
};

}  // namespace tetloom::second_order

#pragma once
// The tets whose smallest dihedral angle is below the one asked for, and what forces it on them.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/error.hpp"
#include "tetloom/filling.hpp"
#include "tetloom/vec.hpp"

namespace tetloom {

inline constexpr std::size_t kMostAcuteTets = 100;

/// Sorts by angle, then by place, and drops all but the first kMostAcuteTets.
void keep_worst(std::vector<AcuteTet>& tets);

}  // namespace tetloom

namespace tetloom::tets {

class WorkingMesh;
struct TetMesh;

/// The smallest dihedral angles of a mesh.
struct DihedralSummary {
  double least = 0;                                   ///< radians; at most `known_least`
  std::size_t below = 0;                              ///< tets with a smaller angle than asked for
  std::size_t angles = 0, triangles = 0, points = 0;  ///< of those, by cause; the last two causes together
  std::vector<AcuteTet> worst;                        ///< as keep_worst leaves them, without entities

  std::size_t forced() const { return angles + triangles + points; }
};

/// Looks only at tets whose quality allows an angle below `least_wanted` (radians). The causes are tried in their
/// order: where the surface leaves several tets at an edge less than that together, none of them has a choice.
/// `known_least`: an angle of this mesh or of another that is summarised with it; what has none below it and below
/// `least_wanted` is not looked at.
DihedralSummary summarize_dihedrals(WorkingMesh& mesh, double least_wanted, double known_least);

/// One mesh alone.
DihedralSummary summarize_dihedrals(WorkingMesh& mesh, double least_wanted);

/// Radians, of the tet of the least quality: most meshes have few smaller ones. That of a regular tet where all are
/// dead.
double dihedral_of_worst(const TetMesh& mesh, std::span<const float> qualities);

}  // namespace tetloom::tets

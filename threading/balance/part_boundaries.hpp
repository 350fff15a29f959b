#pragma once
// Moves cells across the boundaries between targets: fewer cut faces, or better balance by small corrections.
#include <cstdint>
#include <span>

#include "tetloom/tasks.hpp"

namespace tetloom {

/// The tets of one block and where each is bound for.
struct TargetedTets {
  std::span<const std::uint32_t> neighbours;  ///< 4 per tet: neighbour · 4 + its face (not checked), or kNoNeighbour
  std::span<const std::int64_t> weights;      ///< positive, one per tet; empty: 1 each
  std::span<std::uint32_t> targets;           ///< in and out, below part_count
  std::uint32_t part_count = 1;

  static constexpr std::uint32_t kNoNeighbour = 0xffffffff;
};

/// How part boundaries are smoothed.
struct SmoothingOptions {
  double imbalance = 0.03;  ///< bound on a target's weight: (1 + imbalance) times the mean
  int layers = 3;           ///< tets this many faces away from a boundary may still cross it
  int sweeps = 1;           ///< how often all boundaries are visited
  int passes = 3;           ///< at most, of one visit
  double patience = 0.05;   ///< a pass ends after this share of the boundary's tets has moved without gain
};

/// Moves tets between the two targets of each boundary so that fewer faces lie between different targets. Boundaries
/// that share no target are worked on at the same time; each sees what is settled of the others.
///
/// Laws: the number of cut faces never grows; a target grows above the bound only by what a heavier one gives it, so
/// the greatest weight does not. The result depends on the input alone, not on threads. Work after one scan of all tets
/// is proportional to the tets within `layers` of a boundary. Errors: InvalidArgument for arrays of different lengths,
/// targets out of range, weights that are not positive.
///
/// After Fiduccia & Mattheyses 1982, between two targets at a time and confined to a band as in Chevalier & Pellegrini
/// 2006. Departure: a pass ends early when it has gone without gain for long.
void smooth_part_boundaries(const TargetedTets& tets, const TaskRunner& runner, const SmoothingOptions& options = {});

/// Small corrections of balance: how much weight must pass each boundary is computed from the targets' weights as the
/// flow of least norm (Hu & Blake 1999), and tets next to the boundary move, those first that leave the fewest cut
/// faces. A target gives away at most what it has. Where targets are far from balance, or not connected by boundaries,
/// partition anew instead. Returns the weight that has moved. Serial; the result depends on the input alone.
/// Errors: as for smooth_part_boundaries.
std::int64_t diffuse_load(const TargetedTets& tets);

}  // namespace tetloom

#pragma once
// Deals items to parts by their places: recursive bisection by planes, and along a Hilbert curve.
#include <cstdint>
#include <span>

#include "tetloom/communicator.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// The place of an item, such as the centroid of a cell, in model space. 12 bytes, dense in arrays.
struct Point3f {
  float x = 0, y = 0, z = 0;
};

/// The items of one part of this rank.
struct ItemBlock {
  std::span<const Point3f> points;   ///< finite
  std::span<const double> weights;   ///< positive and finite, one per point; empty: 1 each
  std::span<std::uint32_t> targets;  ///< out, one per point
  /// Optional, for tets: 4 codes per item, neighbour · 4 + its face, 0xffffffff for none in this block. Lets planes be
  /// compared by the faces that they cut.
  std::span<const std::uint32_t> neighbours = {};
};

/// The targets first, first + 1, … first + count - 1.
struct TargetRange {
  std::uint32_t first = 0;
  std::uint32_t count = 1;
};

/// Among which planes each cut is chosen.
enum class CutPlanes {
  Axes,    ///< normal to a coordinate axis
  Several  ///< normal to one of the 13 directions that join a cube's centre to its faces, edges and corners
};

/// Weighted recursive bisection by planes: a set of items bound for k targets is cut so that floor(k/2) of k shares of
/// its weight lie on one side. Of the planes that do so the one is taken that cuts the smallest estimated area, which
/// is the density of items along its normal where it lies. Where neighbours are given, it is also multiplied by how far
/// apart neighbours lie along that normal, which gives cut faces: in a lattice some directions cost more than others.
/// `part_count` need not be a power of two.
///
/// Laws: the target of an item is a function of the multiset of all items (place, weight); blocks, ranks and threads
/// do not matter (with neighbours, the faces that blocks know may decide between planes that cost nearly the same).
/// Items at the same place get the same target; places closer than 2^-30 of the longest extent are the
/// same. With weights 1 and different places each cut is off by less than 1/8192 of its set or one item.
/// Weights are rounded to multiples of 2^-20 of the greatest one (at least one multiple), so sums are exact.
/// Where there are fewer places than targets some targets stay without items.
///
/// Every rank calls it with its own blocks. O(n log k) time; per item beside the arrays at most 5 bytes of memory.
/// A round of the search is one collective for all sets; a level takes two for the planes and usually one to three
/// rounds. Errors: InvalidArgument, on all ranks when one has bad input.
///
/// After Berger & Bokhari 1987. Departures: oblique cuts, chosen by estimated area as inertial bisection (Simon 1991)
/// would by its axis; directions are compared on a sample that is drawn by a hash of the items' own coordinates; cuts
/// are found by refined histograms instead of a median.
void partition_rcb(std::span<const ItemBlock> blocks, std::uint32_t part_count, Communicator& communicator,
                   const TaskRunner& runner, CutPlanes planes = CutPlanes::Several);

/// The same for each block on its own into a range of targets of its own: no communication, blocks run in parallel and
/// each result depends on its block alone. Pre: one range per block.
void split_blocks_rcb(std::span<const ItemBlock> blocks, std::span<const TargetRange> ranges, const TaskRunner& runner,
                      CutPlanes planes = CutPlanes::Several);

/// Deals the items in the order of a Hilbert curve (63-bit keys) in stretches of equal weight, target 0 first. Parts
/// are less compact than those of partition_rcb, but neighbouring numbers are neighbours in space. Laws, weights,
/// errors as for partition_rcb, where places closer than 2^-21 of the longest extent are the same. 8 bytes per item
/// beside the arrays.
///
/// The curve of Hamilton & Rau-Chaplin 2008 (entry corners and directions by the Gray code), here for coordinates of
/// equally many bits; the 24 poses of a cube stand in a table in place of their operations on bits.
void partition_sfc(std::span<const ItemBlock> blocks, std::uint32_t part_count, Communicator& communicator,
                   const TaskRunner& runner);
void split_blocks_sfc(std::span<const ItemBlock> blocks, std::span<const TargetRange> ranges, const TaskRunner& runner);

}  // namespace tetloom

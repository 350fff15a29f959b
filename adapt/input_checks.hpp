#pragma once
// What has to be true of the input of adapt_mesh before anything is done with it.
#include "core/sizing/memory_limits.hpp"
#include "tetloom/adapt.hpp"

namespace tetloom::adapt {

/// Throws Error(InvalidArgument) where arrays and indices of `mesh` do not fit, and InputUnsuitable for points that are
/// not finite, for tags of entities above 2^28, and for those of corners and edges that are not in the mesh's table
/// where it has one.
void check_mesh(const Mesh& mesh, const BlockLoop& loop);

/// Throws Error(InvalidArgument) unless there is one metric per point, and InputUnsuitable where one is not finite.
void check_metric(const MetricField& metric, const Mesh& mesh);

/// How much an adaptation holds.
struct AdaptLoad {
  double complexity = 0;     ///< of the metric
  double given = 0;          ///< tets
  double components = 0;     ///< of fields on them that are carried over
  int ranks = 1;             ///< that share all of it
  int ranks_on_machine = 1;  ///< and what is free there
};

/// Throws Error(OutOfMemory) where a unit mesh of that complexity would have more tets than can be counted, or what a
/// rank needs is more than it can get; the message says how much that is, and how many ranks would do.
void check_load(const AdaptLoad& load);
/// The same with limits that are given.
void check_load(const AdaptLoad& load, const MemoryLimits& limits);

/// A number over the bits of all that adaptation depends on, in their order: of the mesh with its classification and
/// the fields that are carried over, the metric or, unless it is null, what makes it of a field, the options. It
/// differs where they do, but for accidents.
std::uint64_t fingerprint(const Mesh& mesh, const MetricField& metric, const SolutionMetric* solution,
                          const AdaptOptions& options, const BlockLoop& loop);

}  // namespace tetloom::adapt

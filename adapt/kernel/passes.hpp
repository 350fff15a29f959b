#pragma once
// Passes over the mesh of one part: coarsening, refinement, swaps and motion.
#include <array>
#include <cstddef>
#include <cstdint>

#include "adapt/kernel/cavity_mesh.hpp"
#include "adapt/kernel/pass_counts.hpp"
#include "mesher/tets/surface_geometry.hpp"
#include "mesher/tets/vertex_star.hpp"
#include "threading/task_runner.hpp"

namespace tetloom::adapt {

struct PassOptions {
  double floor = 0.1;        ///< mean ratio that no operation may go below, unless it was below before
  double collapsible = 0.2;  ///< mean ratio from which on a collapse may make tets worse than those it replaces
};

class Passes {
 public:
  Passes(CavityMesh& mesh, const MetricStage& source, const tets::SurfaceProjector& project, const PassOptions& options,
         const TaskRunner& runner)
      : mesh_(mesh), source_(source), project_(project), options_(options), runner_(runner) {}

  /// Splits edges longer than `longest`, the longest of their neighbourhood first. Returns how many.
  std::size_t split_edges(double longest);
  /// Collapses edges shorter than `shortest`, the shortest first, where that makes none longer than `longest`.
  std::size_t collapse_edges(double shortest, double longest);
  /// Edge and face swaps at tets of a mean ratio below `limit`.
  std::size_t swap(double limit);
  /// Moves vertices of tets of a mean ratio below `limit`, once each.
  std::size_t smooth(double limit);

  const PassCounts& counts() const { return counts_; }

 private:
  struct Edge {
    std::uint32_t a, b;
    float length;
  };

  Verdict split(std::uint32_t a, std::uint32_t b, std::uint32_t tet);
  Verdict collapse(std::uint32_t a, std::uint32_t b, double longest);
  Verdict swap_at(std::uint32_t tet);
  Verdict move(std::uint32_t v);
  Verdict lead_to_model(std::uint32_t v);
  bool can_collapse(std::uint32_t a, std::uint32_t b) const;
  bool pinches(std::uint32_t p, std::uint32_t);
  bool lies_in_planes(const Cavity& cavity) const;
  bool is_flat_enough(const Cavity& cavity, std::uint32_t p) const;
  PackedEntity entity_of_edge(std::uint32_t a, std::uint32_t b) const;
  double bound_of(std::uint32_t a, std::uint32_t b) const;
  bool longest_edge(std::uint32_t tet, float least, Edge& edge) const;
  bool makes_long_edge(std::uint32_t from, std::uint32_t to, double longest);
  bool is_frozen(const Cavity& cavity) const;

  CavityMesh& mesh_;
  const MetricStage& source_;
  const tets::SurfaceProjector& project_;
  PassOptions options_;
  const TaskRunner& runner_;
  PassCounts counts_;
  Cavity cavity_, scratch_;
  MadeQualities made_;
  std::vector<tets::StarTet> star_;
  std::vector<std::uint32_t> marks_;
  std::uint32_t mark_ = 0;
};

}  // namespace tetloom::adapt

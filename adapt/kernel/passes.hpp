#pragma once
// Passes over the mesh of one part: coarsening, refinement, swaps and motion.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "adapt/kernel/cavity_mesh.hpp"
#include "adapt/kernel/star_cavity.hpp"
#include "core/geometry/model_projector.hpp"
#include "core/tets/edge_ring.hpp"
#include "core/tets/star_tet.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

/// What an operation may do.
struct PassOptions {
  double floor = 0.1;           ///< mean ratio that no operation may go below, unless it was below before
  double collapsible = 0.2;     ///< mean ratio from which on a collapse may make tets worse than those it replaces
  double most_tets = HUGE_VAL;  ///< no edge is split where the part has as many
  double size_weight = 1;       ///< of lengths near 1 against shapes, where vertices move; see find_newton_step
};

/// The passes of one round over a part: splits, collapses, swaps and moves.
class Passes {
 public:
  Passes(CavityMesh& mesh, const MetricStage& source, const SurfaceProjector& project, const PassOptions& options,
         const TaskRunner& runner)
      : mesh_(mesh), source_(source), project_(project), options_(options), runner_(runner) {}

  /// Splits edges longer than `longest`, the longest of their neighbourhood first. Returns how many.
  std::size_t split_edges(double longest);
  /// Collapses edges shorter than `shortest`, the shortest first, where that makes none longer than `longest`, or than
  /// nearly the inverse of what they are: one end into the other, or where neither can be done, both into the middle.
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
  // The best operation found so far.
  struct Choice {
    double least;  // quality of what it makes
    std::array<std::uint32_t, 3> core{};
    std::uint32_t core_size = 0, target = kNone;
    tets::RingTriangles triangles{};  // of ring_; none: the core is to be reconnected to the target
  };

  bool longest_edge(std::uint32_t tet, float least, Edge& edge) const;
  // The larger of the two lengths that its ends give an edge, squared: not below the square of its length.
  double bound_of(std::uint32_t a, std::uint32_t b) const {
    const Vec3 e = mesh_.point(b) - mesh_.point(a);
    return std::max(dot(mesh_.to_metric[a].tensor, e), dot(mesh_.to_metric[b].tensor, e));
  }
  GrowingArray<Edge> short_edges(double shortest) const;

  Verdict split(std::uint32_t a, std::uint32_t b, std::uint32_t tet);

  std::optional<Verdict> collapse(std::uint32_t a, std::uint32_t b, double longest);
  Verdict judge_collapse(std::uint32_t from, std::uint32_t to, double longest, double& best);
  Verdict collect_ball(std::uint32_t v, Cavity& ball) const;
  bool has_vertex(const Cavity& cavity, std::uint32_t v) const;
  Verdict merge(std::uint32_t a, std::uint32_t b, double longest);
  Verdict merge_at(std::uint32_t a, std::uint32_t b, const std::vector<Vec3>& normals, double longest);
  bool collapse_with_swaps(const Cavity& ball, std::uint32_t to, double longest);
  bool can_collapse(std::uint32_t a, std::uint32_t b) const;
  bool mark_new_ends(const Cavity& cavity, std::uint32_t to, double longest);
  bool makes_long_edge(std::uint32_t from, std::uint32_t to, double longest);
  double bearable_collapse(double least) const;

  Verdict swap_at(std::uint32_t tet);
  void try_edge_swaps(std::uint32_t tet, const std::array<std::uint32_t, 2>& edge, Choice& best);
  void try_face_swap(std::uint32_t tet, std::uint32_t corner, Choice& best);
  void try_ring(const tets::EdgeRing& ring, Choice& best);
  bool find_ends(const std::array<std::uint32_t, 2>& edge);

  Verdict move(std::uint32_t v);
  Verdict snap_to_model(std::uint32_t v);
  bool remove_from_surface(std::uint32_t v);
  Vec3 find_step(std::uint32_t v, double& badness);
  bool keep_on_entity(std::uint32_t v, Vec3& step) const;
  bool keep_on_face(Vec3& step) const;
  bool keep_on_edge(std::uint32_t v, Vec3& step) const;
  bool try_place(std::uint32_t v, const Vec3& place, double bearable, double badness);
  void take_made_qualities();

  bool is_frozen(const Cavity& cavity) const;
  bool keeps_surface(const Cavity& cavity, std::uint32_t p);
  bool is_flat_enough(const Cavity& cavity, std::uint32_t p) const;
  bool lies_in_planes(const Cavity& cavity) const;
  bool pinches(std::uint32_t p);
  bool has_surface_edge(std::uint32_t v, std::span<const std::uint32_t> ends);
  std::vector<Vec3> normals_of(const Cavity& cavity) const;
  bool turns_no_normal(const Cavity& cavity, const std::vector<Vec3>& normals) const;

  CavityMesh& mesh_;
  const MetricStage& source_;
  const SurfaceProjector& project_;
  PassOptions options_;
  const TaskRunner& runner_;
  PassCounts counts_;
  Cavity cavity_, other_, scratch_;
  StarCavity star_cavity_{mesh_};
  MadeQualities made_, other_made_;
  std::vector<float> beside_;        // qualities of tets that move with a merged edge
  tets::EdgeRing ring_;              // of an edge whose place others may take
  std::vector<std::uint32_t> ends_;  // of edges of the surface that may take an edge's place
  std::vector<tets::StarTet> star_;  // of a vertex that moves, in its metric
  std::vector<std::uint32_t> marks_;
  std::uint32_t mark_ = 0;
};

}  // namespace tetloom::adapt

#pragma once
// The size wanted at a point, and how finely an octree must be cut to hold it. Private to mesher/sizing.
#include <cstdint>
#include <functional>

#include "mesher/sizing/model_facets.hpp"
#include "mesher/sizing/size_targets.hpp"
#include "mesher/sizing/source_tree.hpp"
#include "tetloom/vec.hpp"

namespace tetloom {

/// What becomes of a cell.
enum class CellVerdict : std::uint8_t {
  Global,  ///< a leaf on which the global size holds throughout
  Leaf,    ///< a leaf with sizes at its corners
  Split
};

/// What is known of a cell beside its box. A child starts with its parent's.
struct CellState {
  static constexpr std::uint32_t kNearSurface = 0xffffffffu;
  double least = 0;                              ///< a lower bound of the sources' field in the cell
  std::uint32_t winner = SourceTree::kNoSource;  ///< the source of the model that gives it
  std::uint32_t region = kNearSurface;           ///< the region that holds the whole cell, where that is known
  bool is_own = false;                           ///< `least` was found for this cell: it is no ancestor's
  bool on_source = false;                        ///< the source that gives it holds in the cell
};

/// What a cell has been found to need.
struct JudgedCell {
  CellState state;
  CellVerdict verdict = CellVerdict::Global;
};

/// The sources of small sizes. Refinements come in rounds: `latest` are those of the last round, which `refinements`
/// has as well.
struct FieldSources {
  const SourceTree& model;
  const SourceTree& refinements;
  const SourceTree& latest;
};

/// The smallest of the global size, the sources' field, the sizes of the regions and the callback.
class TargetField {
 public:
  /// `callback` may be empty. Refers to its arguments.
  TargetField(const SizeTargets& targets, const FieldSources& sources, const FacetTree& facets,
              const std::function<double(const Vec3&)>& callback);

  /// `winner` as in SourceTree::size_at, among the sources of the model.
  double size_at(const Vec3& x, std::uint32_t& winner) const;

  /// The same where it was `before` without the latest refinements.
  double lowered_at(const Vec3& x, double before) const;

  /// A lower bound of the sources' field within `radius` of `center`.
  double lower_bound(const Vec3& center, double radius, std::uint32_t& winner) const;

  /// A cell is a leaf once it is about as wide as the least size in it (a little less next to a source, where the field
  /// bends), so that trilinear interpolation follows the field within a few percent; when the field is constant; or
  /// when it lies outside of every region and half an edge length away from all faces, where nobody will ask.
  /// `before`: of the same cell without the latest refinements; null where it was not judged. The answer is the same
  /// with and without.
  CellVerdict classify(const Vec3& center, double width, const JudgedCell* before, CellState& state) const;

  /// The width of the widest leaves next to a source, in sizes.
  double width_at_source() const { return width_at_source_; }

  double global() const { return targets_.global; }
  double gradation() const { return targets_.gradation; }
  /// Whether the field may grow faster than the gradation, so that it has to be enforced afterwards.
  bool may_be_steep() const { return static_cast<bool>(callback_); }

 private:
  double region_size(const Vec3& x) const;
  double callback_size(const Vec3& x) const;
  void find_least(const Vec3& center, double radius, const CellState* before, CellState& state) const;
  CellVerdict judge_by_sources(double width, const CellState& state) const;
  CellVerdict judge_by_callback(const Vec3& center, double width) const;
  CellVerdict judge_by_surface(const Vec3& center, double width, CellState& state) const;

  const SizeTargets& targets_;
  FieldSources sources_;
  const FacetTree& facets_;
  const std::function<double(const Vec3&)>& callback_;
  double width_at_source_, width_away_;  ///< of the widest leaves, in sizes
};

}  // namespace tetloom

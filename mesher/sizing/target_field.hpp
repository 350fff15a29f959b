#pragma once
// The size wanted at a point, and how finely an octree must be cut to hold it. Private to mesher/sizing.
#include <cstdint>
#include <functional>

#include "core/base/vec.hpp"
#include "mesher/sizing/model_facets.hpp"
#include "mesher/sizing/size_targets.hpp"
#include "mesher/sizing/source_tree.hpp"

namespace tetloom {

/// What becomes of a cell.
enum class CellVerdict : std::uint8_t {
  Global,  ///< a leaf on which the global size holds throughout
  Leaf,    ///< a leaf with sizes at its corners
  Split
};

/// The smallest of the global size, the sources' field, the sizes of the regions and the callback.
class TargetField {
 public:
  /// `facets` is needed when a region has a size of its own and may be null otherwise; `callback` may be empty.
  TargetField(const SizeTargets& targets, const SourceTree& sources, const FacetTree* facets,
              const std::function<double(const Vec3&)>& callback)
      : targets_(targets), sources_(sources), facets_(facets), callback_(callback) {}

  /// `winner` as in SourceTree::size_at.
  double size_at(const Vec3& x, std::uint32_t& winner) const;

  /// A lower bound of the sources' field within `radius` of `center`.
  double lower_bound(const Vec3& center, double radius, std::uint32_t& winner) const;

  /// A cell is a leaf once it is about as wide as the sizes in it (half of that next to a source, where the field
  /// bends), so that trilinear interpolation follows the field within a few percent; or when the field is constant.
  CellVerdict classify(const Vec3& center, double width, std::uint32_t& winner) const;

  /// The width of the leaves next to the smallest source.
  double finest_width() const;

  double global() const { return targets_.global; }
  double gradation() const { return targets_.gradation; }
  /// Whether the field may grow faster than the gradation, so that it has to be enforced afterwards.
  bool may_be_steep() const { return static_cast<bool>(callback_); }

 private:
  double region_size(const Vec3& x) const;
  double callback_size(const Vec3& x) const;
  bool callback_needs_split(const Vec3& center, double width, bool& below_global) const;

  const SizeTargets& targets_;
  const SourceTree& sources_;
  const FacetTree* facets_;
  const std::function<double(const Vec3&)>& callback_;
};

}  // namespace tetloom

#include "tetloom/size_field.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/sizing/size_tree.hpp"
#include "tetloom/error.hpp"

namespace tetloom {

SizeField SizeField::uniform(double size) {
  if (!(std::isfinite(size) && size > 0)) throw Error(ErrorCode::InvalidArgument, "a size must be positive and finite");
  SizeField field;
  field.smallest_ = field.largest_ = size;
  return field;
}

SizeField SizeField::from_octree(SizeOctree octree) {
  if (const std::string wrong = validate_octree(octree); !wrong.empty())
    throw Error(ErrorCode::InvalidArgument, "invalid size octree: " + wrong);
  float smallest = 1;
  for (const float ratio : octree.corner_ratios) smallest = std::min(smallest, ratio);
  SizeField field;
  field.largest_ = octree.size;
  field.gradation_ = octree.gradation;
  field.smallest_ = smallest < 1 ? static_cast<double>(smallest) * octree.size : octree.size;
  field.tree_ = std::make_shared<const Tree>(std::move(octree));
  return field;
}

double SizeField::size_at(const Vec3& x) const { return tree_ ? tree_->size_at(x) : largest_; }

std::size_t SizeField::leaf_count() const { return tree_ ? tree_->leaf_count() : 1; }

std::size_t SizeField::memory() const { return sizeof(SizeField) + (tree_ ? tree_->memory() : 0); }

SizeField SizeField::kept_by(const KeepBytes& keep) const {
  SizeField field = *this;
  if (!tree_) return field;
  Tree moved = *tree_;
  moved.move_arrays(keep);
  field.tree_ = std::make_shared<const Tree>(std::move(moved));
  return field;
}

void SizeField::for_each_leaf(const Box3& box, const std::function<void(const SizeLeaf&)>& visit) const {
  if (box.empty()) return;
  if (tree_) return tree_->for_each_leaf(box, visit);
  visit({box, largest_});
}

double SizeField::estimate_tets(const Box3& box) const {
  double count = 0;
  for_each_leaf(box, [&](const SizeLeaf& leaf) {
    const Vec3 extent = leaf.box.hi - leaf.box.lo;
    count += extent.x * extent.y * extent.z * kTetsPerCube / (leaf.size * leaf.size * leaf.size);
  });
  return count;
}

}  // namespace tetloom

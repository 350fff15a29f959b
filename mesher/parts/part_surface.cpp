#include "mesher/parts/part_surface.hpp"

#include <algorithm>
#include <array>
#include <compare>

#include "core/base/lists.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

namespace {

constexpr std::size_t kBlock = 4096;

// What concerns which part: blocks of items find their pairs side by side, then each part picks its own from the
// blocks.
class Pairs {
 public:
  struct Pair {
    PartId part;
    std::uint32_t item;
    friend auto operator<=>(const Pair&, const Pair&) = default;
  };

  Pairs(std::size_t part_count, const TaskRunner& runner) : part_count_(part_count), runner_(runner) {}

  /// Adds the pairs that find(item, pairs) appends, for all items below `count`.
  template <class Find>
  void collect(std::size_t count, const Find& find) {
    const std::size_t before = block_to_pairs_.size();
    block_to_pairs_.resize(before + (count + kBlock - 1) / kBlock);
    runner_.for_blocks(count, kBlock, [&](std::size_t begin, std::size_t end) {
      std::vector<Pair>& pairs = block_to_pairs_[before + begin / kBlock];
      for (std::size_t i = begin; i < end; ++i) find(static_cast<std::uint32_t>(i), pairs);
      sort_unique(pairs);
    });
  }

  /// The items of each part, ascending, and none is left.
  std::vector<std::vector<std::uint32_t>> deal() {
    std::vector<std::vector<std::uint32_t>> part_to_items(part_count_);
    runner_.for_each(part_count_, [&](std::size_t p) {
      std::vector<std::uint32_t>& items = part_to_items[p];
      for (const auto& pairs : block_to_pairs_) {
        auto at = std::lower_bound(pairs.begin(), pairs.end(), Pair{PartId(p), 0});
        for (; at != pairs.end() && at->part == PartId(p); ++at) items.push_back(at->item);
      }
      if (!std::is_sorted(items.begin(), items.end())) sort_unique(items);
    });
    block_to_pairs_.clear();
    return part_to_items;
  }

 private:
  std::size_t part_count_;
  const TaskRunner& runner_;
  std::vector<std::vector<Pair>> block_to_pairs_;
};

using PairList = std::vector<Pairs::Pair>;

}  // namespace

std::size_t PartSurface::pieces(const volume::Complex& complex) {
  return (complex.tri_to_vert.size() + kBlock - 1) / kBlock;
}

PartSurface::PartSurface(const volume::Complex& complex, const SizeField& sizes, const Decomposition& decomposition,
                         double reach, const TaskRunner& runner) {
  Pairs all(decomposition.part_count(), runner);
  std::vector<double> margins(complex.points.size());
  runner.for_blocks(margins.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) margins[i] = reach * sizes.size_at(complex.points[i]);
  });
  const auto find_parts = [&](std::uint32_t point, auto&& visit) {
    const Vec3& x = complex.points[point];
    const double margin = margins[point];
    const Vec3 around{margin, margin, margin};
    decomposition.for_each_in({x - around, x + around}, visit);
  };
  point_to_owner_.resize(complex.points.size());
  std::vector<char> is_deep(complex.points.size());  // no part but its own is within reach
  all.collect(complex.points.size(), [&](std::uint32_t point, PairList& pairs) {
    const Vec3& x = complex.points[point];
    const PartId owner = decomposition.owner_of(x);
    point_to_owner_[point] = owner;
    is_deep[point] = depth_inside(x, decomposition.box(owner)) > margins[point] * (1 + 1e-9);
    if (is_deep[point]) return pairs.push_back({owner, point});
    find_parts(point, [&](PartId part) { pairs.push_back({part, point}); });
  });
  // A triangle with an edge longer than a margin may run through the box of a part that all its points are far from.
  const auto is_large = [&](const std::array<std::uint32_t, 3>& verts) {
    const auto& [a, b, c] = verts;
    const Vec3 &x = complex.points[a], &y = complex.points[b], &z = complex.points[c];
    const double margin = std::min({margins[a], margins[b], margins[c]});
    return std::max({norm2(x - y), norm2(y - z), norm2(z - x)}) > margin * margin;
  };
  const auto find_met = [&](const std::array<std::uint32_t, 3>& verts, auto&& visit) {
    Box3 box;
    for (const std::uint32_t v : verts) box.add(complex.points[v]);
    decomposition.for_each_in(box, visit);
  };
  all.collect(complex.tri_to_vert.size(), [&](std::uint32_t triangle, PairList& pairs) {
    const auto& verts = complex.tri_to_vert[triangle];
    if (is_large(verts))
      find_met(verts, [&](PartId part) {
        for (const std::uint32_t v : verts) pairs.push_back({part, v});
      });
    for (const std::uint32_t v : verts)
      for (const std::uint32_t other : verts)
        if (owner_of(other) != owner_of(v)) pairs.push_back({owner_of(v), other});
  });
  part_to_points_ = all.deal();
  all.collect(complex.tri_to_vert.size(), [&](std::uint32_t triangle, PairList& pairs) {
    const auto& [a, b, c] = complex.tri_to_vert[triangle];
    if (is_large({a, b, c})) find_met({a, b, c}, [&](PartId part) { pairs.push_back({part, triangle}); });
    if (is_deep[a] && owner_of(b) == owner_of(a) && owner_of(c) == owner_of(a))
      return pairs.push_back({owner_of(a), triangle});
    const auto add = [&](PartId part) {
      const auto known = points_of(part);
      for (const std::uint32_t v : {a, b, c})
        if (!std::binary_search(known.begin(), known.end(), v)) return;
      pairs.push_back({part, triangle});
    };
    bool added_b = false, added_c = false;
    find_parts(a, [&](PartId part) {
      add(part);
      added_b |= part == owner_of(b), added_c |= part == owner_of(c);
    });
    if (!added_b) add(owner_of(b));  // where that of the first is farther away
    if (!added_c) add(owner_of(c));
  });
  part_to_triangles_ = all.deal();
}

}  // namespace tetloom::parts

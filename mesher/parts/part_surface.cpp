#include "mesher/parts/part_surface.hpp"

#include <algorithm>
#include <array>
#include <compare>
#include <utility>

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
using Verts = std::array<std::uint32_t, 3>;

// Finds what each part knows.
class SurfaceDealer {
 public:
  SurfaceDealer(const volume::Complex& complex, const SizeField& sizes, const Decomposition& decomposition,
                double reach, const TaskRunner& runner)
      : complex_(complex), decomposition_(decomposition), all_(decomposition.part_count(), runner) {
    margins_.resize(complex.points.size());
    runner.for_blocks(margins_.size(), kBlock, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) margins_[i] = reach * sizes.size_at(complex.points[i]);
    });
  }

  std::vector<PartId> owners;                                 ///< of points
  std::vector<std::vector<std::uint32_t>> points, triangles;  ///< of parts

  void run() {
    owners.resize(complex_.points.size()), is_deep_.resize(complex_.points.size());
    all_.collect(complex_.points.size(), [&](std::uint32_t point, PairList& pairs) { add_near(point, pairs); });
    all_.collect(complex_.tri_to_vert.size(), [&](std::uint32_t triangle, PairList& pairs) {
      add_points_of(complex_.tri_to_vert[triangle], pairs);
    });
    points = all_.deal();
    all_.collect(complex_.tri_to_vert.size(),
                 [&](std::uint32_t triangle, PairList& pairs) { add_triangle(triangle, pairs); });
    triangles = all_.deal();
  }

 private:
  template <class Visit>
  void for_each_near(std::uint32_t point, const Visit& visit) const {
    const Vec3& x = complex_.points[point];
    const Vec3 around{margins_[point], margins_[point], margins_[point]};
    decomposition_.for_each_in({x - around, x + around}, visit);
  }

  // A triangle with an edge longer than a margin may run through the box of a part that all its points are far from.
  bool is_large(const Verts& verts) const {
    const auto& [a, b, c] = verts;
    const Vec3 &x = complex_.points[a], &y = complex_.points[b], &z = complex_.points[c];
    const double margin = std::min({margins_[a], margins_[b], margins_[c]});
    return std::max({norm2(x - y), norm2(y - z), norm2(z - x)}) > margin * margin;
  }

  template <class Visit>
  void for_each_met(const Verts& verts, const Visit& visit) const {
    Box3 box;
    for (const std::uint32_t v : verts) box.add(complex_.points[v]);
    decomposition_.for_each_in(box, visit);
  }

  void add_near(std::uint32_t point, PairList& pairs) {
    const Vec3& x = complex_.points[point];
    const PartId owner = decomposition_.owner_of(x);
    owners[point] = owner;
    is_deep_[point] = depth_inside(x, decomposition_.box(owner)) > margins_[point] * (1 + 1e-9);
    if (is_deep_[point]) return pairs.push_back({owner, point});
    for_each_near(point, [&](PartId part) { pairs.push_back({part, point}); });
  }

  void add_points_of(const Verts& verts, PairList& pairs) const {
    if (is_large(verts))
      for_each_met(verts, [&](PartId part) {
        for (const std::uint32_t v : verts) pairs.push_back({part, v});
      });
    for (const std::uint32_t v : verts)
      for (const std::uint32_t other : verts)
        if (owners[other] != owners[v]) pairs.push_back({owners[v], other});
  }

  void add_triangle(std::uint32_t triangle, PairList& pairs) const {
    const Verts& verts = complex_.tri_to_vert[triangle];
    const auto& [a, b, c] = verts;
    if (is_large(verts)) for_each_met(verts, [&](PartId part) { pairs.push_back({part, triangle}); });
    if (is_deep_[a] && owners[b] == owners[a] && owners[c] == owners[a]) return pairs.push_back({owners[a], triangle});
    const auto add = [&](PartId part) {
      const std::vector<std::uint32_t>& known = points[part.value];
      if (std::ranges::all_of(verts, [&](std::uint32_t v) { return std::ranges::binary_search(known, v); }))
        pairs.push_back({part, triangle});
    };
    bool added_b = false, added_c = false;
    for_each_near(a, [&](PartId part) {
      add(part);
      added_b |= part == owners[verts[1]], added_c |= part == owners[verts[2]];
    });
    if (!added_b) add(owners[b]);  // where that of the first is farther away
    if (!added_c) add(owners[c]);
  }

  const volume::Complex& complex_;
  const Decomposition& decomposition_;
  Pairs all_;
  std::vector<double> margins_;  // of points: how far from a part's box it knows them
  std::vector<char> is_deep_;    // no part but its own is within reach
};

}  // namespace

std::size_t PartSurface::pieces(const volume::Complex& complex) {
  return (complex.tri_to_vert.size() + kBlock - 1) / kBlock;
}

PartSurface::PartSurface(const volume::Complex& complex, const SizeField& sizes, const Decomposition& decomposition,
                         double reach, const TaskRunner& runner) {
  SurfaceDealer dealer(complex, sizes, decomposition, reach, runner);
  dealer.run();
  point_to_owner_ = std::move(dealer.owners);
  part_to_points_ = std::move(dealer.points), part_to_triangles_ = std::move(dealer.triangles);
}

void PartSurface::keep(std::span<const PartId> parts) {
  for (auto* lists : {&part_to_points_, &part_to_triangles_}) {
    std::vector<std::vector<std::uint32_t>> kept(lists->size());
    for (const PartId part : parts) kept[part.value] = std::move((*lists)[part.value]);
    *lists = std::move(kept);
  }
}

}  // namespace tetloom::parts

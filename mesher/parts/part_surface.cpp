#include "mesher/parts/part_surface.hpp"

#include <algorithm>
#include <array>
#include <compare>
#include <functional>
#include <utility>

#include "core/base/lists.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/own_share.hpp"

namespace tetloom::parts {

namespace {

constexpr std::size_t kBlock = 4096;

// What concerns which part: each rank finds the pairs of its share of the items, in blocks side by side; then each part
// picks its own from the blocks of all ranks.
class Pairs {
 public:
  struct Pair {
    PartId part;
    std::uint32_t item;
    friend auto operator<=>(const Pair&, const Pair&) = default;
  };

  Pairs(std::size_t part_count, const SharedWork& work) : part_count_(part_count), work_(work) {}

  /// Adds the pairs that find(item, pairs) appends, for this rank's share of `items`. Not a collective call.
  template <class Find>
  void collect(const ItemRange& items, const Find& find) {
    const std::size_t before = block_to_pairs_.size();
    block_to_pairs_.resize(before + (items.size() + kBlock - 1) / kBlock);
    work_.runner().for_blocks(items.size(), kBlock, [&](std::size_t begin, std::size_t end) {
      std::vector<Pair>& pairs = block_to_pairs_[before + begin / kBlock];
      for (std::size_t i = begin; i < end; ++i) find(static_cast<std::uint32_t>(items.first + i), pairs);
      sort_unique(pairs);
    });
  }

  /// The items of each part of this rank, ascending, and none is left. A collective call.
  std::vector<std::vector<std::uint32_t>> deal() {
    if (work_.rank_count() > 1) send();
    std::vector<std::vector<std::uint32_t>> part_to_items(part_count_);
    const std::vector<PartId> parts = work_.ranks().parts_of_rank(part_count_);
    work_.each([&] {
      work_.runner().for_each(parts.size(), [&](std::size_t p) {
        std::vector<std::uint32_t>& items = part_to_items[parts[p].value];
        for (const auto& pairs : block_to_pairs_) {
          auto at = std::lower_bound(pairs.begin(), pairs.end(), Pair{parts[p], 0});
          for (; at != pairs.end() && at->part == parts[p]; ++at) items.push_back(at->item);
        }
        if (!std::is_sorted(items.begin(), items.end(), std::less_equal())) sort_unique(items);
      });
    });
    block_to_pairs_.clear();
    return part_to_items;
  }

 private:
  // Parts of a rank are consecutive.
  void send() {
    const std::vector<Bytes> sent = work_.exchange([&](std::span<MessageWriter> to) {
      for (std::vector<Pair>& pairs : block_to_pairs_) {
        for (auto begin = pairs.cbegin(); begin != pairs.cend();) {
          const int rank = work_.ranks().rank_of(begin->part, part_count_);
          const auto end = std::find_if(begin, pairs.cend(), [&](const Pair& pair) {
            return work_.ranks().rank_of(pair.part, part_count_) != rank;
          });
          to[static_cast<std::size_t>(rank)].put_array<Pair>({begin, end});
          begin = end;
        }
        pairs = {};
      }
    });
    work_.each([&] {
      block_to_pairs_.clear();
      for (const Bytes& bytes : sent)
        for (MessageReader reader(bytes); !reader.at_end();) block_to_pairs_.push_back(reader.get_array<Pair>());
    });
  }

  std::size_t part_count_;
  const SharedWork& work_;
  std::vector<std::vector<Pair>> block_to_pairs_;
};

using PairList = std::vector<Pairs::Pair>;
using Verts = std::array<std::uint32_t, 3>;

// Finds what each part knows.
class SurfaceDealer {
 public:
  SurfaceDealer(const volume::Complex& complex, const SizeField& sizes, const Decomposition& decomposition,
                double reach, const SharedWork& work)
      : complex_(complex),
        decomposition_(decomposition),
        work_(work),
        own_points_(own_share(complex.points.size(), work)),
        own_triangles_(own_share(complex.tri_to_vert.size(), work)),
        all_(decomposition.part_count(), work) {
    work.each([&] { look_at_points(sizes, reach); });
  }

  std::vector<std::vector<std::uint32_t>> points, triangles;  ///< of the parts of this rank

  void run() {
    work_.each([&] {
      all_.collect(own_points_, [&](std::uint32_t point, PairList& pairs) { add_near(point, pairs); });
      all_.collect(own_triangles_, [&](std::uint32_t triangle, PairList& pairs) {
        add_points_of(complex_.tri_to_vert[triangle], pairs);
      });
    });
    points = all_.deal();
    work_.each([&] {
      all_.collect(own_triangles_, [&](std::uint32_t triangle, PairList& pairs) { add_triangle(triangle, pairs); });
    });
    triangles = all_.deal();
    work_.each([&] {
      work_.runner().for_each(points.size(), [&](std::size_t part) { drop_unknown(points[part], triangles[part]); });
    });
  }

 private:
  // Of the points of this rank's share and of its triangles.
  void look_at_points(const SizeField& sizes, double reach) {
    const std::size_t count = complex_.points.size();
    std::vector<char> is_asked(count, work_.rank_count() == 1);
    if (work_.rank_count() > 1) {
      std::fill_n(is_asked.begin() + static_cast<std::ptrdiff_t>(own_points_.first), own_points_.size(), 1);
      for (std::size_t t = own_triangles_.first; t < own_triangles_.last; ++t)
        for (const std::uint32_t v : complex_.tri_to_vert[t]) is_asked[v] = 1;
    }
    margins_.resize(count), owners_.resize(count), is_deep_.resize(count);
    work_.runner().for_blocks(count, kBlock, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        if (!is_asked[i]) continue;
        const Vec3& x = complex_.points[i];
        margins_[i] = reach * sizes.size_at(x), owners_[i] = decomposition_.owner_of(x);
        is_deep_[i] = depth_inside(x, decomposition_.box(owners_[i])) > margins_[i] * (1 + 1e-9);
      }
    });
  }

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

  void add_near(std::uint32_t point, PairList& pairs) const {
    if (is_deep_[point]) return pairs.push_back({owners_[point], point});
    for_each_near(point, [&](PartId part) { pairs.push_back({part, point}); });
  }

  void add_points_of(const Verts& verts, PairList& pairs) const {
    if (is_large(verts))
      for_each_met(verts, [&](PartId part) {
        for (const std::uint32_t v : verts) pairs.push_back({part, v});
      });
    for (const std::uint32_t v : verts)
      for (const std::uint32_t other : verts)
        if (owners_[other] != owners_[v]) pairs.push_back({owners_[v], other});
  }

  // Those that may know all of its points; which of them do is known where their points are.
  void add_triangle(std::uint32_t triangle, PairList& pairs) const {
    const Verts& verts = complex_.tri_to_vert[triangle];
    const auto& [a, b, c] = verts;
    if (is_large(verts)) for_each_met(verts, [&](PartId part) { pairs.push_back({part, triangle}); });
    for (const std::uint32_t v : verts) pairs.push_back({owners_[v], triangle});  // b's may be far from a
    if (is_deep_[a] && owners_[b] == owners_[a] && owners_[c] == owners_[a]) return;
    for_each_near(a, [&](PartId part) { pairs.push_back({part, triangle}); });
  }

  void drop_unknown(std::span<const std::uint32_t> known, std::vector<std::uint32_t>& of_part) const {
    std::erase_if(of_part, [&](std::uint32_t triangle) {
      return !std::ranges::all_of(complex_.tri_to_vert[triangle],
                                  [&](std::uint32_t v) { return std::ranges::binary_search(known, v); });
    });
  }

  const volume::Complex& complex_;
  const Decomposition& decomposition_;
  const SharedWork& work_;
  const ItemRange own_points_, own_triangles_;
  Pairs all_;
  std::vector<double> margins_;  // of points: how far from a part's box it knows them
  std::vector<PartId> owners_;
  std::vector<char> is_deep_;  // no part but its own is within reach
};

}  // namespace

std::size_t PartSurface::pieces(const volume::Complex& complex) {
  return (complex.tri_to_vert.size() + kBlock - 1) / kBlock;
}

PartSurface::PartSurface(const volume::Complex& complex, const SizeField& sizes, const Decomposition& decomposition,
                         double reach, const SharedWork& work)
    : points_(complex.points), decomposition_(&decomposition) {
  SurfaceDealer dealer(complex, sizes, decomposition, reach, work);
  dealer.run();
  part_to_points_ = std::move(dealer.points), part_to_triangles_ = std::move(dealer.triangles);
}

}  // namespace tetloom::parts

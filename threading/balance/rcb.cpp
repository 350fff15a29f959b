#include <limits>

#include "tetloom/tasks.hpp"
#include "threading/balance/bisection_detail.hpp"
#include "threading/balance/cut_planes_detail.hpp"

namespace tetloom {

namespace balance_detail {

namespace {

/// Keys of items under planes: the place along the normal, then x, y, z against ties.
class PlaneKeys {
 public:
  PlaneKeys(const Items& items, TargetRange range, CutPlanes planes)
      : items_(items), chooser_(items, range, planes), range_(range) {}

  std::span<const std::uint64_t> highest() const { return kHighest; }

  void plan(std::span<ItemSet> sets) { normals_ = chooser_.choose(sets); }
  void split(std::span<const ItemSet> sets) { chooser_.split(sets, normals_); }

  struct Reader {
    Frame frame;
    const Point3f* points;
    const std::array<std::int64_t, 3>* normals;

    std::uint64_t first(std::size_t set, std::size_t item) const {
      return height(normals[set], frame.place_of(points[item]));
    }
    std::uint64_t component(std::size_t, std::size_t item, std::uint32_t component) const {
      return static_cast<std::uint64_t>(frame.place_of(points[item])[component - 1]);
    }
  };
  Reader reader(std::uint32_t block) const {
    return {items_.frame(), items_.blocks()[block].points.data(), normals_.data()};
  }

 private:
  static constexpr std::array<std::uint64_t, 4> kHighest{kHighestHeight, (1U << Frame::kPlaceBits) - 1,
                                                         (1U << Frame::kPlaceBits) - 1, (1U << Frame::kPlaceBits) - 1};
  const Items& items_;
  PlaneChooser chooser_;
  TargetRange range_;
  std::vector<Normal> normals_;
};

void split_rcb(const Items& items, TargetRange range, CutPlanes planes) {
  PlaneKeys keys(items, range, planes);
  Bisection(items, keys, range).run();
}

}  // namespace
}  // namespace balance_detail

void partition_rcb(std::span<const ItemBlock> blocks, std::uint32_t part_count, Communicator& communicator,
                   const TaskRunner& runner, CutPlanes planes) {
  balance_detail::check_part_count(part_count);
  const balance_detail::Items items(blocks, communicator, runner);
  balance_detail::split_rcb(items, {0, part_count}, planes);
}

void split_blocks_rcb(std::span<const ItemBlock> blocks, std::span<const TargetRange> ranges, const TaskRunner& runner,
                      CutPlanes planes) {
  balance_detail::check_ranges(blocks, ranges);
  runner.for_each(blocks.size(), [&](std::size_t b) {
    const auto alone = make_thread_communicator();
    const balance_detail::Items items(blocks.subspan(b, 1), *alone, runner);
    balance_detail::split_rcb(items, ranges[b], planes);
  });
}

}  // namespace tetloom

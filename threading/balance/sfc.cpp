#include <vector>

#include "core/spatial/hilbert.hpp"
#include "tetloom/tasks.hpp"
#include "threading/balance/bisection_detail.hpp"

namespace tetloom {

namespace balance_detail {

namespace {

/// Keys along the curve, computed once.
class CurveKeys {
 public:
  explicit CurveKeys(const Items& items) : keys_(items.blocks().size()) {
    for (std::size_t b = 0; b < keys_.size(); ++b) keys_[b].resize(items.blocks()[b].points.size());
    items.for_chunks(items.lanes(0), [&](std::size_t, const Chunk& chunk) {
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
        const auto place = items.frame().place_of(items.blocks()[chunk.block].points[i]);
        keys_[chunk.block][i] = hilbert_key(place[0] >> kDropped, place[1] >> kDropped, place[2] >> kDropped);
      }
    });
  }

  std::span<const std::uint64_t> highest() const { return kHighest; }
  void plan(std::span<ItemSet>) {}
  void split(std::span<const ItemSet>) {}
  struct Reader {
    const std::uint64_t* keys;
    std::uint64_t first(std::size_t, std::size_t item) const { return keys[item]; }
    std::uint64_t component(std::size_t, std::size_t item, std::uint32_t) const { return keys[item]; }
  };
  Reader reader(std::uint32_t block) const { return {keys_[block].data()}; }

 private:
  static constexpr int kDropped = Frame::kPlaceBits - kHilbertBits;
  static constexpr std::array<std::uint64_t, 1> kHighest{(std::uint64_t{1} << (3 * kHilbertBits)) - 1};
  std::vector<std::vector<std::uint64_t>> keys_;
};

void split_sfc(const Items& items, TargetRange range) {
  CurveKeys keys(items);
  Bisection(items, keys, range).run();
}

}  // namespace
}  // namespace balance_detail

void partition_sfc(std::span<const ItemBlock> blocks, std::uint32_t part_count, Communicator& communicator,
                   const TaskRunner& runner) {
  balance_detail::check_part_count(part_count);
  balance_detail::split_sfc(balance_detail::Items(blocks, communicator, runner), {0, part_count});
}

void split_blocks_sfc(std::span<const ItemBlock> blocks, std::span<const TargetRange> ranges,
                      const TaskRunner& runner) {
  balance_detail::check_ranges(blocks, ranges);
  runner.for_each(blocks.size(), [&](std::size_t b) {
    const auto alone = make_thread_communicator();
    const balance_detail::Items items(blocks.subspan(b, 1), *alone, runner);
    balance_detail::split_sfc(items, ranges[b]);
  });
}

}  // namespace tetloom

#include "mesher/lattice/site_blocks.hpp"

#include <bit>
#include <unordered_map>

#include "core/tets/tet_mesh.hpp"

namespace tetloom::lattice {

namespace {

using tets::kNone;

constexpr int kPlaceBits = 21;

std::uint64_t key_of(const std::array<std::int32_t, 3>& place) {
  std::uint64_t key = 0;
  for (const std::int32_t x : place)
    key = key << kPlaceBits | (static_cast<std::uint64_t>(x) & ((std::uint64_t{1} << kPlaceBits) - 1));
  return key;
}

template <int Kinds>
class BlockMaker {
 public:
  BlockMaker(const LatticeShape& shape, std::size_t sites)
      : shape_(shape), shift_(std::countr_zero(static_cast<unsigned>(shape.parts()))) {
    index_of_.reserve(sites / (Kinds * kBlockCubes) * 2);
  }

  void add(const Site& site, std::uint32_t vert, bool near_surface) {
    const std::array<std::int32_t, 3> cube{site.i >> shift_, site.j >> shift_, site.k >> shift_};
    const std::array<std::int32_t, 3> place{cube[0] >> 2, cube[1] >> 2, cube[2] >> 2};
    if (const std::uint64_t key = key_of(place); blocks_.empty() || key != last_key_) {
      last_ = block_at(key, place);
      last_key_ = key;
    }
    const int kind = shape_.kind_of(site), index = cube_index(cube[0] & 3, cube[1] & 3, cube[2] & 3);
    blocks_[last_].to_vert[static_cast<std::size_t>(kind * kBlockCubes + index)] = vert;
    if (near_surface) blocks_[last_].near_surface[static_cast<std::size_t>(kind)] |= std::uint64_t{1} << index;
  }

  std::vector<SiteBlock<Kinds>> finish() {
    for (SiteBlock<Kinds>& block : blocks_) {
      for (int i = 0; i < 27; ++i) {
        const auto at = index_of_.find(
            key_of({block.place[0] + i % 3 - 1, block.place[1] + i / 3 % 3 - 1, block.place[2] + i / 9 - 1}));
        block.around[static_cast<std::size_t>(i)] = at == index_of_.end() ? kNone : at->second;
      }
    }
    return std::move(blocks_);
  }

 private:
  std::uint32_t block_at(std::uint64_t key, const std::array<std::int32_t, 3>& place) {
    const auto [at, is_new] = index_of_.try_emplace(key, static_cast<std::uint32_t>(blocks_.size()));
    if (is_new) {
      SiteBlock<Kinds>& block = blocks_.emplace_back();
      block.place = place;
      block.to_vert.fill(kNone);
    }
    return at->second;
  }

  const LatticeShape& shape_;
  int shift_;  // bits of a coordinate within its cube
  std::unordered_map<std::uint64_t, std::uint32_t> index_of_;
  std::vector<SiteBlock<Kinds>> blocks_;
  std::uint32_t last_ = 0;
  std::uint64_t last_key_ = 0;
};

}  // namespace

template <int Kinds>
std::vector<SiteBlock<Kinds>> make_site_blocks(const LevelPoints& level, std::uint32_t first_vert) {
  BlockMaker<Kinds> maker(level.lattice.shape(), level.sites.size());
  for (std::size_t i = 0; i < level.sites.size(); ++i)
    maker.add(level.sites[i], first_vert + static_cast<std::uint32_t>(i), level.near_surface[i] != 0);
  return maker.finish();
}

template std::vector<SiteBlock<2>> make_site_blocks<2>(const LevelPoints&, std::uint32_t);
template std::vector<SiteBlock<8>> make_site_blocks<8>(const LevelPoints&, std::uint32_t);

}  // namespace tetloom::lattice

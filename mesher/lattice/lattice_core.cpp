#include "mesher/lattice/lattice_core.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <new>

#include "mesher/lattice/block_tables.hpp"
#include "mesher/lattice/site_blocks.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::lattice {

namespace {

using tets::FaceCode;
using tets::kNone;
using tets::TetMesh;

constexpr std::size_t kMostTets = std::size_t{1} << 29;

// What a block gives: its tets stand one after the other from first_tet on, by cube, then by type.
template <class TypeSet>
struct BlockTets {
  std::array<std::uint32_t, kBlockCubes> first_tet;
  std::array<TypeSet, kBlockCubes> types{};  // which there are in each cube
};

template <int Kinds, int Types>
class LevelEmitter {
 public:
  LevelEmitter(TetMesh& mesh, const LevelPoints& level, LatticeCore& core, const TaskRunner& runner)
      : mesh_(mesh), core_(core), runner_(runner), tables_(level.lattice.shape()) {
    const auto first_vert = static_cast<std::uint32_t>(mesh.points.size());
    own_end_ = first_vert + static_cast<std::uint32_t>(level.sites.size() - level.foreign);
    if (core.level_to_vert.empty()) core.first_own_end = own_end_;
    core.level_to_vert.push_back(first_vert);
    mesh.points.reserve(mesh.points.size() + level.sites.size());
    for (const Site& site : level.sites) mesh.points.push_back(level.lattice.point(site));
    runner.check_cancelled();
    blocks_ = make_site_blocks<Kinds>(level, first_vert);
    own_blocks_ = count_own_blocks();
  }

  void emit(bool is_alone) {
    complete_.resize(blocks_.size());
    pure_.resize(blocks_.size());
    tets_.resize(blocks_.size());
    for_each_block([&](std::size_t b) { find_complete(b); });
    for_each_block([&](std::size_t b) { find_pure(b, is_alone); });
    std::size_t count = mesh_.size();
    for_each_own_block([&](std::size_t b) { count = number_tets(b, count); });
    reserve(count);
    for_each_own_block([&](std::size_t b) { write_tets(b, b + 1 < own_blocks_ ? tets_[b + 1].first_tet[0] : count); });
    for_each_own_block([&](std::size_t b) { note_shell(b); });
    std::sort(shell_.begin(), shell_.end(), [](const Shell& s, const Shell& t) { return s.vert < t.vert; });
    for (const Shell& site : shell_) {
      core_.shell_verts.push_back(site.vert);
      core_.pure_around.push_back(site.pure_around);
    }
  }

 private:
  // Blocks stand in the order of their first sites, and those of the part come before all others.
  std::size_t count_own_blocks() const {
    const auto is_own = [&](const SiteBlock<Kinds>& block) {
      return std::any_of(block.to_vert.begin(), block.to_vert.end(), [&](std::uint32_t v) { return v < own_end_; });
    };
    return static_cast<std::size_t>(std::partition_point(blocks_.begin(), blocks_.end(), is_own) - blocks_.begin());
  }

  template <class Visit>
  void for_each_block(const Visit& visit) const {
    for_each_block_before(blocks_.size(), visit);
  }
  // Those with sites of the part stand first: tets and shell vertices begin at these.
  template <class Visit>
  void for_each_own_block(const Visit& visit) const {
    for_each_block_before(own_blocks_, visit);
  }
  template <class Visit>
  void for_each_block_before(std::size_t end, const Visit& visit) const {
    constexpr std::size_t kBetweenChecks = 1024;  // some ten milliseconds
    for (std::size_t b = 0; b < end; ++b) {
      if (b % kBetweenChecks == 0) runner_.check_cancelled();
      visit(b);
    }
  }

  using Tables = BlockTables<Kinds, Types>;
  using TypeSet = typename Tables::TypeSet;
  using Bits = SiteBits<Kinds>;
  template <class Value>
  using Padded = std::array<Value, std::size_t{Kinds} * kPaddedCubes>;

  // value(block, kind, cube) of all sites in and around block b; `absent` where no block is.
  template <class Value, class Get>
  Padded<Value> pad(std::size_t b, Value absent, const Get& value) const {
    Padded<Value> padded;
    const auto& around = blocks_[b].around;
    for (std::size_t place = 0; place < kPaddedCubes; ++place) {
      const std::uint32_t block = around[kPaddedPlaces[place].around];
      for (std::size_t kind = 0; kind < Kinds; ++kind) {
        padded[kind * kPaddedCubes + place] =
            block == kNone ? absent : value(block, kind, std::size_t{kPaddedPlaces[place].cube});
      }
    }
    return padded;
  }

  // Sites for which `holds` is true and is so for all around.
  Bits all_around(const Padded<char>& holds) const {
    Bits bits{};
    for (int kind = 0; kind < Kinds; ++kind) {
      for (int z = 0; z < kBlockWidth; ++z) {
        for (int y = 0; y < kBlockWidth; ++y) {
          for (int x = 0; x < kBlockWidth; ++x) {
            const int place = kind * kPaddedCubes + padded_index(x, y, z);
            bool all = holds[place];
            for (const int step : tables_.around_offset[kind]) all &= holds[place + step] != 0;
            bits[kind] |= std::uint64_t{all} << cube_index(x, y, z);
          }
        }
      }
    }
    return bits;
  }

  void find_complete(std::size_t b) {
    complete_[b] = all_around(pad<char>(b, 0, [&](std::uint32_t block, std::size_t kind, std::size_t cube) -> char {
      return blocks_[block].to_vert[kind * kBlockCubes + cube] != kNone;
    }));
  }

  void find_pure(std::size_t b, bool is_alone) {
    pure_[b] = is_alone ? complete_[b] : complete_around(b);
    for (std::size_t kind = 0; kind < Kinds; ++kind) pure_[b][kind] &= ~blocks_[b].near_surface[kind];
  }

  Bits complete_around(std::size_t b) const {
    return all_around(pad<char>(b, 0, [&](std::uint32_t block, std::size_t kind, std::size_t cube) -> char {
      return complete_[block][kind] >> cube & 1;
    }));
  }

  std::size_t number_tets(std::size_t b, std::size_t count) {
    const Padded<std::uint32_t> verts = pad_verts(b);
    const Padded<char> pure = pad_pure(b);
    for_each_cube([&](std::size_t cube, std::size_t place) {
      tets_[b].first_tet[cube] = static_cast<std::uint32_t>(count);
      tets_[b].types[cube] = types_at(verts.data() + place, pure.data() + place);
      count += Tables::count(tets_[b].types[cube]);
    });
    if (count > kMostTets) throw std::bad_alloc();
    return count;
  }

  TypeSet types_at(const std::uint32_t* verts, const char* pure) const {
    TypeSet types = 0;
    for (int kind = 0; kind < Kinds; ++kind) {
      const TypeSet first = tables_.first_at[kind];
      if (verts[kind * kPaddedCubes] >= own_end_) continue;  // nothing, or another part's
      if (pure[kind * kPaddedCubes]) {
        types = static_cast<TypeSet>(types | first);  // everything around is there
      } else {
        types = static_cast<TypeSet>(types | mixed_types(first, verts, pure));
      }
    }
    return types;
  }

  TypeSet mixed_types(TypeSet among, const std::uint32_t* verts, const char* pure) const {
    TypeSet types = 0;
    for (TypeSet rest = among; rest != 0; rest = static_cast<TypeSet>(rest & (rest - 1))) {
      const int type = std::countr_zero(rest);
      const auto& [a, b, c, d] = tables_.types[type].vert_offset;
      const bool there = verts[b] != kNone && verts[c] != kNone && verts[d] != kNone;
      if (there && (pure[a] | pure[b] | pure[c] | pure[d])) types = static_cast<TypeSet>(types | TypeSet{1} << type);
    }
    return types;
  }

  void reserve(std::size_t count) {
    mesh_.to_vert.resize_for_overwrite(count * 4);
    mesh_.to_neighbor.resize_for_overwrite(count * 4);
    mesh_.to_fixed.resize(count, 0);
  }

  void write_tets(std::size_t b, std::size_t end) {
    if (tets_[b].first_tet[0] == end) return;
    const Padded<std::uint32_t> verts = pad_verts(b);
    note_beyond_first(verts, tets_[b].first_tet[0], static_cast<std::uint32_t>(end));
    std::array<std::uint32_t, kPaddedCubes> first{};
    std::array<TypeSet, kPaddedCubes> types{};
    for (std::size_t place = 0; place < kPaddedCubes; ++place) {
      const std::uint32_t block = blocks_[b].around[kPaddedPlaces[place].around];
      if (block == kNone) continue;
      first[place] = tets_[block].first_tet[kPaddedPlaces[place].cube];
      types[place] = tets_[block].types[kPaddedPlaces[place].cube];
    }
    for_each_cube([&](std::size_t, std::size_t place) {
      std::uint32_t tet = first[place];
      for (TypeSet rest = types[place]; rest != 0; rest = static_cast<TypeSet>(rest & (rest - 1)), ++tet) {
        const auto& type = tables_.types[std::countr_zero(rest)];
        std::uint32_t* v = mesh_.to_vert.data() + std::size_t{tet} * 4;
        FaceCode* n = mesh_.to_neighbor.data() + std::size_t{tet} * 4;
        for (int i = 0; i < 4; ++i) v[i] = verts[place + type.vert_offset[i]];
        for (std::uint32_t i = 0; i < 4; ++i) {
          const std::size_t other = place + type.behind_offset[i];
          const auto bit = static_cast<TypeSet>(TypeSet{1} << type.behind_type[i]);
          const bool there = (types[other] & bit) != 0;
          n[i] = there ? FaceCode(first[other] + Tables::count(static_cast<TypeSet>(types[other] & (bit - 1))),
                                  type.behind_face[i])
                       : FaceCode();
          if (!there) core_.open_faces.push_back({tet, i});
        }
      }
    });
  }

  void note_beyond_first(const Padded<std::uint32_t>& verts, std::uint32_t begin, std::uint32_t end) {
    unsigned any = 0;
    for (const std::uint32_t v : verts) any |= (v >= core_.first_own_end) & (v != kNone);
    if (any == 0) return;
    if (!core_.beyond_first.empty() && core_.beyond_first.back()[1] == begin) {
      core_.beyond_first.back()[1] = end;
    } else {
      core_.beyond_first.push_back({begin, end});
    }
  }

  void note_shell(std::size_t b) {
    if (!has_shell(b)) return;
    const Padded<char> pure = pad_pure(b);
    for (std::size_t kind = 0; kind < Kinds; ++kind) {
      for_each_cube([&](std::size_t cube, std::size_t place) {
        const std::uint32_t vert = blocks_[b].to_vert[kind * kBlockCubes + cube];
        if (vert >= own_end_ || (pure_[b][kind] >> cube & 1)) return;
        const auto& around = tables_.around_offset[kind];
        const std::size_t site = kind * kPaddedCubes + place;
        unsigned pure_around = 0;
        for (std::size_t i = 0; i < tables_.around_count[kind]; ++i)
          pure_around |= unsigned{pure[site + static_cast<std::size_t>(around[i])] != 0} << i;
        shell_.push_back({vert, static_cast<std::uint16_t>(pure_around)});
      });
    }
  }

  bool has_shell(std::size_t b) const {
    for (std::size_t kind = 0; kind < Kinds; ++kind) {
      for (std::size_t cube = 0; cube < kBlockCubes; ++cube)
        if (blocks_[b].to_vert[kind * kBlockCubes + cube] < own_end_ && !(pure_[b][kind] >> cube & 1)) return true;
    }
    return false;
  }

  Padded<char> pad_pure(std::size_t b) const {
    return pad<char>(b, 0, [&](std::uint32_t block, std::size_t kind, std::size_t cube) -> char {
      return pure_[block][kind] >> cube & 1;
    });
  }

  Padded<std::uint32_t> pad_verts(std::size_t b) const {
    return pad<std::uint32_t>(b, kNone, [&](std::uint32_t block, std::size_t kind, std::size_t cube) {
      return blocks_[block].to_vert[kind * kBlockCubes + cube];
    });
  }

  // Calls visit(cube, place in a padded block).
  template <class Visit>
  static void for_each_cube(const Visit& visit) {
    for (int z = 0; z < kBlockWidth; ++z) {
      for (int y = 0; y < kBlockWidth; ++y) {
        for (int x = 0; x < kBlockWidth; ++x)
          visit(static_cast<std::size_t>(cube_index(x, y, z)), static_cast<std::size_t>(padded_index(x, y, z)));
      }
    }
  }

  struct Shell {
    std::uint32_t vert;
    std::uint16_t pure_around;
  };

  TetMesh& mesh_;
  LatticeCore& core_;
  const TaskRunner& runner_;
  std::uint32_t own_end_ = 0;  // vertices from here on are another part's
  std::vector<Shell> shell_;
  Tables tables_;
  std::vector<SiteBlock<Kinds>> blocks_;
  std::size_t own_blocks_ = 0;
  std::vector<Bits> complete_, pure_;  // per block
  std::vector<BlockTets<TypeSet>> tets_;
};

}  // namespace

LatticeCore emit_core(TetMesh& mesh, std::span<const LevelPoints> levels, const TaskRunner& runner) {
  LatticeCore core;
  for (const LevelPoints& level : levels) {
    const bool is_alone = levels.size() == 1;
    if (level.lattice.kind() == LatticeKind::A15) {
      LevelEmitter<8, 46>(mesh, level, core, runner).emit(is_alone);
    } else {
      LevelEmitter<2, 12>(mesh, level, core, runner).emit(is_alone);
    }
  }
  core.level_to_vert.push_back(static_cast<std::uint32_t>(mesh.points.size()));
  return core;
}

}  // namespace tetloom::lattice

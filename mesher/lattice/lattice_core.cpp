#include "mesher/lattice/lattice_core.hpp"

#include <algorithm>
#include <bit>
#include <new>

#include "mesher/lattice/site_blocks.hpp"

namespace tetloom::lattice {

namespace {

using tets::FaceCode;
using tets::kNone;
using tets::TetMesh;

constexpr std::size_t kMostTets = std::size_t{1} << 29;
constexpr int kTypes = 12;

// A tet of the lattice joins an edge along `axis` from a corner p to the next corner p', and an edge between centres
// q, q' that is opposite to it: one of the four edges around, counter-clockwise seen from p' to p.
//
//        q3 ---- q2          v
//        |   p    |          |
//        q0 ---- q1          +-- u        u, v: the axes after `axis`
//
// Type axis · 4 + i names the tet (p, p', q_i, q_i+1) at the corner p. Each tet has exactly one such name.
struct Step {
  int x, y, z;
};
constexpr int along(const Step& step, int axis) { return axis == 0 ? step.x : axis == 1 ? step.y : step.z; }
constexpr Step unit(int axis, int length) {
  return {axis == 0 ? length : 0, axis == 1 ? length : 0, axis == 2 ? length : 0};
}
constexpr Step operator+(const Step& a, const Step& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr int offset(const Step& step) { return (step.z * kPaddedWidth + step.y) * kPaddedWidth + step.x; }

// Of the cube whose centre is q_i, from the cube whose corner is p.
constexpr Step centre_step(int axis, int i) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  return unit(u, i == 1 || i == 2 ? 0 : -1) + unit(v, i >= 2 ? 0 : -1);
}

// The neighbour behind a face of a type: at which corner, of which type, and through which of its faces.
struct Behind {
  Step step;
  int type, face;
};
constexpr Behind behind(int type, int face) {
  const int axis = type / 4, i = type % 4;
  if (face == 2) return {{0, 0, 0}, axis * 4 + (i + 1) % 4, 3};
  if (face == 3) return {{0, 0, 0}, axis * 4 + (i + 3) % 4, 2};
  // The other corner edge at p' (face 0) or p (face 1) runs along the axis w on which q_i and q_i+1 agree, towards
  // them.
  const int w = i % 2 == 0 ? (axis + 2) % 3 : (axis + 1) % 3;
  const bool upwards = i == 1 || i == 2;
  const Step from = face == 0 ? unit(axis, 1) : Step{0, 0, 0};
  const Step base = upwards ? from : from + unit(w, -1);
  // Seen from that edge, the edge q_i q_i+1 lies on the side of p, which is below p' along `axis` and above p.
  const bool axis_is_u = axis == (w + 1) % 3;
  const int j = face == 0 ? (axis_is_u ? 3 : 0) : (axis_is_u ? 1 : 2);
  return {base, w * 4 + j, upwards ? 1 : 0};
}

struct Type {
  std::array<int, 4> half_offset;  // of its vertices in a padded block, halves one after the other
  std::array<int, 4> behind_offset, behind_type, behind_face;
};
constexpr std::array<Type, kTypes> make_types() {
  std::array<Type, kTypes> types{};
  for (int type = 0; type < kTypes; ++type) {
    const int axis = type / 4, i = type % 4;
    types[type].half_offset = {0, offset(unit(axis, 1)), kPaddedCubes + offset(centre_step(axis, i)),
                               kPaddedCubes + offset(centre_step(axis, (i + 1) % 4))};
    for (int face = 0; face < 4; ++face) {
      const Behind b = behind(type, face);
      types[type].behind_offset[face] = offset(b.step);
      types[type].behind_type[face] = b.type;
      types[type].behind_face[face] = b.face;
    }
  }
  return types;
}
constexpr std::array<Type, kTypes> kTypeTable = make_types();

// Bits set in a set of types: a table, since the baseline of x86-64 has no instruction for it.
constexpr std::array<std::uint8_t, 1 << kTypes> make_type_counts() {
  std::array<std::uint8_t, 1 << kTypes> counts{};
  for (std::size_t types = 1; types < counts.size(); ++types)
    counts[types] = static_cast<std::uint8_t>(counts[types >> 1] + (types & 1));
  return counts;
}
constexpr std::array<std::uint8_t, 1 << kTypes> kTypeCounts = make_type_counts();

// What a block gives: its tets stand one after the other from first_tet on, by corner, then by type.
struct BlockTets {
  std::array<std::uint32_t, kBlockCubes> first_tet;
  std::array<std::uint16_t, kBlockCubes> types{};  // which there are at each corner
};

// Of the 14 sites around a site of each half, in a padded block.
constexpr std::array<std::array<int, 14>, 2> make_around_offsets() {
  std::array<std::array<int, 14>, 2> offsets{};
  for (int half = 0; half < 2; ++half) {
    for (int i = 0; i < 14; ++i) {
      const SiteStep& step = kSiteSteps[half][i];
      offsets[half][i] = (step.half - half) * kPaddedCubes + offset({step.x, step.y, step.z});
    }
  }
  return offsets;
}

constexpr std::array<std::array<int, 14>, 2> kAroundOffsets = make_around_offsets();

template <class Value>
using Padded = std::array<Value, kPaddedSites>;

class LevelEmitter {
 public:
  LevelEmitter(TetMesh& mesh, const LevelPoints& level, LatticeCore& core, const TaskRunner& runner)
      : mesh_(mesh), core_(core), runner_(runner) {
    const auto first_vert = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.reserve(mesh.points.size() + level.sites.size());
    for (const Site& site : level.sites) mesh.points.push_back(level.lattice.point(site));
    runner.check_cancelled();
    blocks_ = make_site_blocks(level, first_vert);
  }

  void emit(bool is_alone) {
    complete_.resize(blocks_.size());
    pure_.resize(blocks_.size());
    tets_.resize(blocks_.size());
    for_each_block([&](std::size_t b) { find_complete(b); });
    for_each_block([&](std::size_t b) { find_pure(b, is_alone); });
    std::size_t count = mesh_.size();
    for_each_block([&](std::size_t b) { count = number_tets(b, count); });
    reserve(count);
    for_each_block([&](std::size_t b) { write_tets(b); });
    for_each_block([&](std::size_t b) { note_shell(b); });
  }

 private:
  template <class Visit>
  void for_each_block(const Visit& visit) const {
    constexpr std::size_t kBetweenChecks = 1024;  // some ten milliseconds
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      if (b % kBetweenChecks == 0) runner_.check_cancelled();
      visit(b);
    }
  }

  // value(block, half, cube) of all sites in and around block b; `absent` where no block is.
  template <class Value, class Get>
  Padded<Value> pad(std::size_t b, Value absent, const Get& value) const {
    Padded<Value> padded;
    const auto& around = blocks_[b].around;
    for (std::size_t place = 0; place < kPaddedCubes; ++place) {
      const std::uint32_t block = around[kPaddedPlaces[place].around];
      for (std::size_t half = 0; half < 2; ++half) {
        padded[half * kPaddedCubes + place] =
            block == kNone ? absent : value(block, half, std::size_t{kPaddedPlaces[place].cube});
      }
    }
    return padded;
  }

  // Sites for which `holds` is true and is so for the 14 around.
  static SiteBits all_around(const Padded<char>& holds) {
    SiteBits bits{};
    for (int half = 0; half < 2; ++half) {
      for (int z = 0; z < kBlockWidth; ++z) {
        for (int y = 0; y < kBlockWidth; ++y) {
          for (int x = 0; x < kBlockWidth; ++x) {
            const int place = half * kPaddedCubes + padded_index(x, y, z);
            bool all = holds[place];
            for (const int step : kAroundOffsets[half]) all &= holds[place + step] != 0;
            bits[half] |= std::uint64_t{all} << cube_index(x, y, z);
          }
        }
      }
    }
    return bits;
  }

  void find_complete(std::size_t b) {
    complete_[b] = all_around(pad<char>(b, 0, [&](std::uint32_t block, std::size_t half, std::size_t cube) -> char {
      return blocks_[block].to_vert[half * kBlockCubes + cube] != kNone;
    }));
  }

  void find_pure(std::size_t b, bool is_alone) {
    pure_[b] = is_alone ? complete_[b] : complete_around(b);
    for (std::size_t half = 0; half < 2; ++half) pure_[b][half] &= ~blocks_[b].near_surface[half];
  }

  SiteBits complete_around(std::size_t b) const {
    return all_around(pad<char>(b, 0, [&](std::uint32_t block, std::size_t half, std::size_t cube) -> char {
      return complete_[block][half] >> cube & 1;
    }));
  }

  std::size_t number_tets(std::size_t b, std::size_t count) {
    const Padded<std::uint32_t> verts = pad_verts(b);
    const Padded<char> pure = pad<char>(b, 0, [&](std::uint32_t block, std::size_t half, std::size_t cube) -> char {
      return pure_[block][half] >> cube & 1;
    });
    for_each_cube([&](std::size_t cube, std::size_t place) {
      tets_[b].first_tet[cube] = static_cast<std::uint32_t>(count);
      std::uint16_t types = 0;
      if (verts[place] != kNone) types = types_at(verts.data() + place, pure.data() + place);
      tets_[b].types[cube] = types;
      count += kTypeCounts[types];
    });
    if (count > kMostTets) throw std::bad_alloc();
    return count;
  }

  static std::uint16_t types_at(const std::uint32_t* verts, const char* pure) {
    if (pure[0]) return (1 << kTypes) - 1;  // everything around is there
    std::uint16_t types = 0;
    for (int type = 0; type < kTypes; ++type) {
      const auto& [a, b, c, d] = kTypeTable[type].half_offset;
      const bool there = verts[b] != kNone && verts[c] != kNone && verts[d] != kNone;
      if (there && (pure[a] | pure[b] | pure[c] | pure[d])) types = static_cast<std::uint16_t>(types | 1 << type);
    }
    return types;
  }

  void reserve(std::size_t count) {
    mesh_.to_vert.resize_for_overwrite(count * 4);
    mesh_.to_neighbor.resize_for_overwrite(count * 4);
    mesh_.to_fixed.resize(count, 0);
  }

  void write_tets(std::size_t b) {
    const Padded<std::uint32_t> verts = pad_verts(b);
    std::array<std::uint32_t, kPaddedCubes> first{};
    std::array<std::uint16_t, kPaddedCubes> types{};
    for (std::size_t place = 0; place < kPaddedCubes; ++place) {
      const std::uint32_t block = blocks_[b].around[kPaddedPlaces[place].around];
      if (block == kNone) continue;
      first[place] = tets_[block].first_tet[kPaddedPlaces[place].cube];
      types[place] = tets_[block].types[kPaddedPlaces[place].cube];
    }
    for_each_cube([&](std::size_t, std::size_t place) {
      std::uint32_t tet = first[place];
      for (unsigned rest = types[place]; rest != 0; rest &= rest - 1, ++tet) {
        const Type& type = kTypeTable[std::countr_zero(rest)];
        std::uint32_t* v = mesh_.to_vert.data() + std::size_t{tet} * 4;
        FaceCode* n = mesh_.to_neighbor.data() + std::size_t{tet} * 4;
        for (int i = 0; i < 4; ++i) v[i] = verts[place + type.half_offset[i]];
        for (int i = 0; i < 4; ++i) {
          const std::size_t other = place + type.behind_offset[i];
          const unsigned bit = 1u << type.behind_type[i];
          const bool there = (types[other] & bit) != 0;
          n[i] = there ? (first[other] + kTypeCounts[types[other] & (bit - 1)]) * 4 + type.behind_face[i] : kNone;
          if (!there) core_.open_faces.push_back(tet * 4 + i);
        }
      }
    });
  }

  void note_shell(std::size_t b) {
    for (std::size_t half = 0; half < 2; ++half) {
      for (std::size_t cube = 0; cube < kBlockCubes; ++cube) {
        const std::uint32_t vert = blocks_[b].to_vert[half * kBlockCubes + cube];
        if (vert != kNone && !(pure_[b][half] >> cube & 1)) core_.shell_verts.push_back(vert);
      }
    }
  }

  Padded<std::uint32_t> pad_verts(std::size_t b) const {
    return pad<std::uint32_t>(b, kNone, [&](std::uint32_t block, std::size_t half, std::size_t cube) {
      return blocks_[block].to_vert[half * kBlockCubes + cube];
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

  TetMesh& mesh_;
  LatticeCore& core_;
  const TaskRunner& runner_;
  std::vector<SiteBlock> blocks_;
  std::vector<SiteBits> complete_, pure_;  // per block
  std::vector<BlockTets> tets_;
};

}  // namespace

LatticeCore emit_core(TetMesh& mesh, std::span<const LevelPoints> levels, const TaskRunner& runner) {
  LatticeCore core;
  for (const LevelPoints& level : levels) LevelEmitter(mesh, level, core, runner).emit(levels.size() == 1);
  std::sort(core.shell_verts.begin(), core.shell_verts.end());
  return core;
}

}  // namespace tetloom::lattice

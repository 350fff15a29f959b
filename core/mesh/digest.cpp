#include "tetloom/check.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

#include "core/base/grain.hpp"
#include "core/mesh/digest_sums.hpp"
#include "core/mesh/mesh_access.hpp"
#include "core/mesh/mid_nodes.hpp"
#include "core/mesh/siphash_detail.hpp"

namespace tetloom {
namespace {

using detail::Hash128;
using detail::siphash128;

// The key names the scheme, so that a later version cannot be taken for this one; its second half keeps kinds apart.
constexpr std::uint64_t kScheme = 0x317473656769646d;  // "mdigest1"
enum class Kind : std::uint64_t { Point, Edge, Triangle, Tet, Whole, Quad, Pyramid, Prism, Hex, MidNode };
constexpr std::uint64_t key_of(Kind kind) { return static_cast<std::uint64_t>(kind); }

std::uint64_t coordinate_bits(double x) { return std::bit_cast<std::uint64_t>(x == 0 ? 0.0 : x); }

Hash128 hash_point(const Vec3& x, const ModelEntity& entity) {
  const std::uint64_t entity_word =
      entity.valid() ? (static_cast<std::uint64_t>(entity.dim) << 32) | entity.index : ~std::uint64_t{0};
  const std::array<std::uint64_t, 4> words{coordinate_bits(x.x), coordinate_bits(x.y), coordinate_bits(x.z),
                                           entity_word};
  return siphash128(words, kScheme, key_of(Kind::Point));
}

template <std::size_t N>
using Vertices = std::array<std::uint32_t, N>;
using PointHashes = std::vector<std::uint64_t>;

/// Of an edge, a triangle or a tet: over its points in ascending order and its orientation.
template <std::size_t N>
Hash128 hash_simplex(const Vertices<N>& element, std::uint32_t entity, const PointHashes& point_hash, Kind kind) {
  std::array<std::uint64_t, N + 1> words;
  for (std::size_t i = 0; i < N; ++i) words[i] = point_hash[element[i]];
  bool odd = false, twins = false;
  for (std::size_t i = 1; i < N; ++i)
    for (std::size_t j = i; j > 0 && words[j] <= words[j - 1]; --j) {
      twins |= words[j] == words[j - 1];
      if (words[j] == words[j - 1]) break;
      std::swap(words[j], words[j - 1]);
      odd = !odd;
    }
  // Points that cannot be told apart leave the orientation without a meaning.
  words[N] = (static_cast<std::uint64_t>(entity) << 1) | (odd && !twins ? 1u : 0u);
  return siphash128(words, kScheme, key_of(kind));
}

template <std::size_t N>
using Turn = std::array<std::uint8_t, N>;

/// All `Count` numberings of an element that two rotations lead to.
template <std::size_t Count, std::size_t N>
constexpr std::array<Turn<N>, Count> all_turns(const Turn<N>& first, const Turn<N>& second) {
  std::array<Turn<N>, Count> turns{};
  std::size_t found = 1;
  for (std::size_t i = 0; i < N; ++i) turns[0][i] = static_cast<std::uint8_t>(i);
  for (std::size_t t = 0; t < found; ++t)
    for (const Turn<N>& rotation : {first, second}) {
      Turn<N> next{};
      for (std::size_t i = 0; i < N; ++i) next[i] = turns[t][rotation[i]];
      bool known = false;
      for (std::size_t k = 0; k < found; ++k) known |= turns[k] == next;
      if (!known) turns[found++] = next;
    }
  return turns;
}

constexpr Turn<4> kQuadTurn{1, 2, 3, 0};
constexpr Turn<5> kPyramidTurn{1, 2, 3, 0, 4};
constexpr auto kQuadTurns = all_turns<4>(kQuadTurn, kQuadTurn);
constexpr auto kPyramidTurns = all_turns<4>(kPyramidTurn, kPyramidTurn);
constexpr auto kPrismTurns = all_turns<6>(Turn<6>{1, 2, 0, 4, 5, 3}, Turn<6>{3, 5, 4, 0, 2, 1});
constexpr auto kHexTurns = all_turns<24>(Turn<8>{1, 2, 3, 0, 5, 6, 7, 4}, Turn<8>{4, 5, 1, 0, 7, 6, 2, 3});

/// Of any other element: over its points in that of its numberings which gives the smallest sequence.
template <std::size_t N, std::size_t Count>
Hash128 hash_turned(const Vertices<N>& element, std::uint32_t entity, const PointHashes& point_hash,
                    const std::array<Turn<N>, Count>& turns, Kind kind) {
  std::array<std::uint64_t, N + 1> best, words;
  for (std::size_t t = 0; t < Count; ++t) {
    for (std::size_t i = 0; i < N; ++i) words[i] = point_hash[element[turns[t][i]]];
    words[N] = entity;
    if (t == 0 || words < best) best = words;
  }
  return siphash128(best, kScheme, key_of(kind));
}

Hash128 hash_cell(const Vertices<4>& v, std::uint32_t region, const PointHashes& hashes) {
  return hash_simplex(v, region, hashes, Kind::Tet);
}
Hash128 hash_cell(const Vertices<5>& v, std::uint32_t region, const PointHashes& hashes) {
  return hash_turned(v, region, hashes, kPyramidTurns, Kind::Pyramid);
}
Hash128 hash_cell(const Vertices<6>& v, std::uint32_t region, const PointHashes& hashes) {
  return hash_turned(v, region, hashes, kPrismTurns, Kind::Prism);
}
Hash128 hash_cell(const Vertices<8>& v, std::uint32_t region, const PointHashes& hashes) {
  return hash_turned(v, region, hashes, kHexTurns, Kind::Hex);
}

/// The sum of hash(i) over all i < count.
template <class Hash>
Hash128 sum_of(std::size_t count, const BlockLoop& loop, const Hash& hash) {
  const auto sums =
      map_blocks(loop, count, kCopyGrain, Hash128{}, [&](std::size_t begin, std::size_t end, Hash128& sum) {
        Hash128 of_block;
        for (std::size_t i = begin; i < end; ++i) of_block += hash(i);
        sum = of_block;
      });
  Hash128 total;
  for (const Hash128& sum : sums) total += sum;
  return total;
}

/// Which mid node lies on which edge.
Hash128 sum_mid_nodes(const Mesh& mesh, const PointHashes& hashes, const BlockLoop& loop) {
  const std::size_t first = vertex_count(mesh);
  return sum_of(mesh.mid_to_vert.size(), loop, [&](std::size_t i) {
    const auto [low, high] = std::minmax(hashes[mesh.mid_to_vert[i][0]], hashes[mesh.mid_to_vert[i][1]]);
    return siphash128(std::array<std::uint64_t, 3>{low, high, hashes[first + i]}, kScheme, key_of(Kind::MidNode));
  });
}

std::string to_hex(const Hash128& hash) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint64_t word : {hash.high, hash.low})
    for (int shift = 60; shift >= 0; shift -= 4) text += kDigits[(word >> shift) & 15];
  return text;
}

/// The hashes of all points; the sum of those that count goes to `sum`.
PointHashes hash_points(const Mesh& mesh, std::span<const std::uint8_t> counts, const BlockLoop& loop, Hash128& sum) {
  PointHashes point_hash(mesh.points.size());
  sum = sum_of(mesh.points.size(), loop, [&](std::size_t i) {
    const Hash128 hash = hash_point(mesh.points[i], entity_of_point(mesh, i));
    point_hash[i] = hash.low;
    return counts.empty() || counts[i] != 0 ? hash : Hash128{};
  });
  return point_hash;
}

constexpr std::uint64_t kFieldScheme = 0x3174736567696466;  // "fdigest1"
enum class FieldKind : std::uint64_t { Name, Point, Cell, Whole };

Hash128 hash_name(const std::string& name) {
  std::vector<std::uint64_t> words(name.size() / 8 + 1);
  for (std::size_t i = 0; i < name.size(); ++i)
    words[i / 8] |= static_cast<std::uint64_t>(static_cast<unsigned char>(name[i])) << (8 * (i % 8));
  words.push_back(name.size());
  return siphash128(words, kFieldScheme, static_cast<std::uint64_t>(FieldKind::Name));
}

/// Hashes the tuples of a field, together with its name and what they hang on.
class FieldHash {
 public:
  FieldHash(const MeshField& field, FieldKind kind) : field_(field), kind_(kind), name_(hash_name(field.name)) {}

  /// The sum over `count` tuples from number `first` on, with the hashes that `carrier` gives for 0, 1, ...
  template <class Carrier>
  Hash128 sum(std::size_t first, std::size_t count, const BlockLoop& loop, const Carrier& carrier) const {
    const auto sums =
        map_blocks(loop, count, kCopyGrain, Hash128{}, [&](std::size_t begin, std::size_t end, Hash128& sum) {
          std::vector<std::uint64_t> words = head();
          for (std::size_t i = begin; i < end; ++i) sum += of_tuple(first + i, carrier(i), words);
        });
    Hash128 total;
    for (const Hash128& sum : sums) total += sum;
    return total;
  }

 private:
  std::size_t components() const { return static_cast<std::size_t>(field_.components); }
  std::vector<std::uint64_t> head() const {
    std::vector<std::uint64_t> words{name_.low, name_.high, components(), 0, 0};
    words.resize(5 + components());
    return words;
  }
  Hash128 of_tuple(std::size_t i, const Hash128& carrier, std::vector<std::uint64_t>& words) const {
    words[3] = carrier.low;
    words[4] = carrier.high;
    for (std::size_t c = 0; c < components(); ++c) words[5 + c] = coordinate_bits(field_.values[i * components() + c]);
    return siphash128(words, kFieldScheme, static_cast<std::uint64_t>(kind_));
  }

  const MeshField& field_;
  FieldKind kind_;
  Hash128 name_;
};

}  // namespace

void DigestSums::add(const DigestSums& other) {
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    Hash128 sum{kinds[i].low, kinds[i].high};
    sum += {other.kinds[i].low, other.kinds[i].high};
    kinds[i] = {kinds[i].count + other.kinds[i].count, sum.low, sum.high};
  }
}

DigestSums digest_sums(const Mesh& mesh, std::span<const std::uint8_t> counts, const BlockLoop& loop) {
  require_consistent(mesh, loop);
  DigestSums sums;
  const auto note = [&](std::size_t kind, std::size_t count, const Hash128& sum) {
    sums.kinds[kind] = {count, sum.low, sum.high};
  };
  Hash128 point_sum;
  const PointHashes hashes = hash_points(mesh, counts, loop, point_sum);
  const auto uncounted = static_cast<std::size_t>(std::count(counts.begin(), counts.end(), 0));
  note(DigestSums::kPoints, mesh.points.size() - uncounted, point_sum);
  const auto note_simplices = [&](std::size_t place, const auto& elements, const auto& entities, Kind kind) {
    note(place, elements.size(), sum_of(elements.size(), loop, [&](std::size_t e) {
           return hash_simplex(elements[e], entities[e], hashes, kind);
         }));
  };
  note_simplices(DigestSums::kEdges, mesh.edge_to_vert, mesh.edge_to_entity, Kind::Edge);
  note_simplices(DigestSums::kTriangles, mesh.tri_to_vert, mesh.tri_to_entity, Kind::Triangle);
  note(DigestSums::kQuads, mesh.quad_to_vert.size(), sum_of(mesh.quad_to_vert.size(), loop, [&](std::size_t q) {
         return hash_turned(mesh.quad_to_vert[q], mesh.quad_to_entity[q], hashes, kQuadTurns, Kind::Quad);
       }));
  for_each_cell_kind(mesh, [&](CellKind kind, const auto& cells, const auto& regions) {
    note(DigestSums::kCells[static_cast<std::size_t>(kind)], cells.size(),
         sum_of(cells.size(), loop, [&](std::size_t c) { return hash_cell(cells[c], regions[c], hashes); }));
  });
  note(DigestSums::kMidNodes, mesh.mid_to_vert.size(), sum_mid_nodes(mesh, hashes, loop));
  return sums;
}

std::string digest_of(const DigestSums& sums) {
  const auto& kinds = sums.kinds;
  std::vector<std::uint64_t> words;
  const auto add = [&](std::size_t first, std::size_t last) {
    for (std::size_t kind = first; kind < last; ++kind) words.push_back(kinds[kind].count);
    for (std::size_t kind = first; kind < last; ++kind) words.insert(words.end(), {kinds[kind].low, kinds[kind].high});
  };
  add(DigestSums::kPoints, DigestSums::kQuads);
  const bool has_others = std::any_of(kinds.begin() + DigestSums::kQuads, kinds.begin() + DigestSums::kMidNodes,
                                      [](const DigestSums::Sum& sum) { return sum.count > 0; });
  if (has_others) add(DigestSums::kQuads, DigestSums::kMidNodes);
  if (kinds[DigestSums::kMidNodes].count > 0) add(DigestSums::kMidNodes, kinds.size());
  return to_hex(siphash128(words, kScheme, key_of(Kind::Whole)));
}

std::string mesh_digest(const Mesh& mesh, const BlockLoop& loop) { return digest_of(digest_sums(mesh, {}, loop)); }

std::string field_digest(const Mesh& mesh, const BlockLoop& loop) {
  require_consistent(mesh, loop);
  Hash128 point_sum, cell_sum, unused;
  const PointHashes hashes = hash_points(mesh, {}, loop, unused);
  for (const MeshField& field : mesh.point_fields)
    point_sum += FieldHash(field, FieldKind::Point).sum(0, mesh.points.size(), loop, [&](std::size_t i) {
      return Hash128{hashes[i], 0};
    });
  for (const MeshField& field : mesh.cell_fields) {
    const FieldHash hash(field, FieldKind::Cell);
    std::size_t first = 0;
    for_each_cell_kind(mesh, [&](CellKind, const auto& cells, const auto& regions) {
      cell_sum +=
          hash.sum(first, cells.size(), loop, [&](std::size_t c) { return hash_cell(cells[c], regions[c], hashes); });
      first += cells.size();
    });
  }
  const std::array<std::uint64_t, 6> words{
      mesh.point_fields.size(), mesh.cell_fields.size(), point_sum.low, point_sum.high, cell_sum.low, cell_sum.high};
  return to_hex(siphash128(words, kFieldScheme, static_cast<std::uint64_t>(FieldKind::Whole)));
}

}  // namespace tetloom

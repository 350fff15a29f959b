#include "core/mesh/digest.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

#include "core/mesh/incidence_detail.hpp"
#include "core/mesh/mesh_access.hpp"
#include "core/mesh/siphash_detail.hpp"

namespace tetloom {
namespace {

using detail::Hash128;
using detail::siphash128;

// The key names the scheme, so that a later version cannot be taken for this one; its second half keeps kinds apart.
constexpr std::uint64_t kScheme = 0x317473656769646d;  // "mdigest1"
enum class Kind : std::uint64_t { Point, Edge, Triangle, Tet, Whole };
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
Hash128 hash_elements(const std::vector<std::array<std::uint32_t, N>>& elements,
                      const std::vector<std::uint32_t>& entities, const std::vector<std::uint64_t>& point_hash,
                      Kind kind) {
  Hash128 sum;
  for (std::size_t e = 0; e < elements.size(); ++e) {
    std::array<std::uint64_t, N + 1> words;
    for (std::size_t i = 0; i < N; ++i) words[i] = point_hash[elements[e][i]];
    bool odd = false, twins = false;
    for (std::size_t i = 1; i < N; ++i)
      for (std::size_t j = i; j > 0 && words[j] <= words[j - 1]; --j) {
        twins |= words[j] == words[j - 1];
        if (words[j] == words[j - 1]) break;
        std::swap(words[j], words[j - 1]);
        odd = !odd;
      }
    // Points that cannot be told apart leave the orientation without a meaning.
    words[N] = (static_cast<std::uint64_t>(entities[e]) << 1) | (odd && !twins ? 1u : 0u);
    sum += siphash128(words, kScheme, key_of(kind));
  }
  return sum;
}

std::string to_hex(const Hash128& hash) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint64_t word : {hash.high, hash.low})
    for (int shift = 60; shift >= 0; shift -= 4) text += kDigits[(word >> shift) & 15];
  return text;
}

}  // namespace

std::string mesh_digest(const Mesh& mesh) {
  require_consistent(mesh);
  std::vector<std::uint64_t> point_hash(mesh.points.size());
  std::array<Hash128, 4> sums;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Hash128 hash = hash_point(mesh.points[i], entity_of_point(mesh, i));
    point_hash[i] = hash.low;
    sums[0] += hash;
  }
  sums[1] = hash_elements(mesh.edge_to_vert, mesh.edge_to_entity, point_hash, Kind::Edge);
  sums[2] = hash_elements(mesh.tri_to_vert, mesh.tri_to_entity, point_hash, Kind::Triangle);
  sums[3] = hash_elements(mesh.tet_to_vert, mesh.tet_to_entity, point_hash, Kind::Tet);
  const std::array<std::uint64_t, 12> words{mesh.points.size(),
                                            mesh.edge_to_vert.size(),
                                            mesh.tri_to_vert.size(),
                                            mesh.tet_to_vert.size(),
                                            sums[0].low,
                                            sums[0].high,
                                            sums[1].low,
                                            sums[1].high,
                                            sums[2].low,
                                            sums[2].high,
                                            sums[3].low,
                                            sums[3].high};
  return to_hex(siphash128(words, kScheme, key_of(Kind::Whole)));
}

}  // namespace tetloom

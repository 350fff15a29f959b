#include <array>
#include <bit>
#include <cstddef>

#include "core/io/hdf5/hdf5_detail.hpp"

namespace tetloom::detail {
namespace {

struct State {
  std::uint32_t a, b, c;
};

void mix(State& s) {
  s.a -= s.c, s.a ^= std::rotl(s.c, 4), s.c += s.b;
  s.b -= s.a, s.b ^= std::rotl(s.a, 6), s.a += s.c;
  s.c -= s.b, s.c ^= std::rotl(s.b, 8), s.b += s.a;
  s.a -= s.c, s.a ^= std::rotl(s.c, 16), s.c += s.b;
  s.b -= s.a, s.b ^= std::rotl(s.a, 19), s.a += s.c;
  s.c -= s.b, s.c ^= std::rotl(s.b, 4), s.b += s.a;
}

void finish(State& s) {
  s.c ^= s.b, s.c -= std::rotl(s.b, 14);
  s.a ^= s.c, s.a -= std::rotl(s.c, 11);
  s.b ^= s.a, s.b -= std::rotl(s.a, 25);
  s.c ^= s.b, s.c -= std::rotl(s.b, 16);
  s.a ^= s.c, s.a -= std::rotl(s.c, 4);
  s.b ^= s.a, s.b -= std::rotl(s.a, 14);
  s.c ^= s.b, s.c -= std::rotl(s.b, 24);
}

// Adds up to 12 bytes.
void add(State& s, std::string_view bytes) {
  std::array<std::uint32_t, 3> words{};
  for (std::size_t i = 0; i < bytes.size(); ++i)
    words[i / 4] += std::uint32_t{static_cast<unsigned char>(bytes[i])} << 8 * (i % 4);
  s.a += words[0], s.b += words[1], s.c += words[2];
}

}  // namespace

std::uint32_t hdf5_checksum(std::string_view bytes) {
  constexpr std::size_t kBlock = 12;
  const std::uint32_t start = 0xdeadbeefu + static_cast<std::uint32_t>(bytes.size());
  State s{start, start, start};
  if (bytes.empty()) return s.c;
  for (; bytes.size() > kBlock; bytes.remove_prefix(kBlock)) {
    add(s, bytes.substr(0, kBlock));
    mix(s);
  }
  add(s, bytes);
  finish(s);
  return s.c;
}

}  // namespace tetloom::detail

// The tables of a tet's corners agree with each other and with space.
#include "core/tets/tet_topology.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "core/predicates/predicates.hpp"
#include "tetloom/vec.hpp"

using namespace tetloom;
using namespace tetloom::tets;

namespace {

const std::array<Vec3, 4> kCorners{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // of a positive tet

int sign_of(std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
  return orient3d(kCorners[a], kCorners[b], kCorners[c], kCorners[d]);
}

}  // namespace

TEST_CASE("a face is opposite to its corner and turns counter-clockwise seen from outside") {
  for (std::size_t face = 0; face < 4; ++face) {
    const auto& [a, b, c] = kFaceVerts[face];
    CHECK(std::set<std::size_t>{face, a, b, c}.size() == 4);
    CHECK(sign_of(a, b, c, face) < 0);
  }
}

TEST_CASE("the corners of an edge and the other two are an even permutation; the opposite edge has the other two") {
  std::set<std::array<std::uint8_t, 2>> edges;
  for (std::size_t edge = 0; edge < 6; ++edge) {
    const auto& [a, b, c, d] = kEdgeCorners[edge];
    CHECK(sign_of(a, b, c, d) > 0);
    CHECK(a < b);
    CHECK(kEdgeVerts[5 - edge] == std::array{std::min(c, d), std::max(c, d)});
    edges.insert(kEdgeVerts[edge]);
  }
  CHECK(edges.size() == 6);
}

TEST_CASE("the corners beside two others ascend, and the parity of all four is known") {
  for (std::uint8_t a = 0; a < 4; ++a)
    for (std::uint8_t b = 0; b < 4; ++b) {
      if (a == b) continue;
      const auto& [c, d] = kOtherCorners[a][b];
      CHECK(c < d);
      CHECK(std::set<int>{a, b, c, d}.size() == 4);
      CHECK(kIsEven[a][b] == (sign_of(a, b, c, d) > 0));
    }
}

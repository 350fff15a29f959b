// The predicates against independent exact arithmetic: __int128 where coordinates are small integers, and rationals in
// a naive base-2^16 integer elsewhere.
#include "core/predicates/predicates.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <vector>

using namespace tetloom;

namespace {

__extension__ using Wide = __int128;

int sign(Wide x) { return x < 0 ? -1 : x > 0 ? 1 : 0; }

struct Grid3 {
  long x, y, z;
  Vec3 scaled(double scale, const Vec3& offset = {}) const {
    return {scale * static_cast<double>(x) + offset.x, scale * static_cast<double>(y) + offset.y,
            scale * static_cast<double>(z) + offset.z};
  }
};

Wide determinant(const Grid3& o, const Grid3& a, const Grid3& b, const Grid3& c) {
  const Wide ax = a.x - o.x, ay = a.y - o.y, az = a.z - o.z, bx = b.x - o.x, by = b.y - o.y, bz = b.z - o.z;
  const Wide cx = c.x - o.x, cy = c.y - o.y, cz = c.z - o.z;
  return ax * (by * cz - bz * cy) - ay * (bx * cz - bz * cx) + az * (bx * cy - by * cx);
}

Wide lift(const Grid3& p, const Grid3& o) {
  const Wide x = p.x - o.x, y = p.y - o.y, z = p.z - o.z;
  return x * x + y * y + z * z;
}

// Laplace expansion along the lifted column; positive when e is inside of a positive tetrahedron.
int insphere_oracle(const Grid3& a, const Grid3& b, const Grid3& c, const Grid3& d, const Grid3& e) {
  return sign(lift(a, e) * determinant(e, b, c, d) - lift(b, e) * determinant(e, a, c, d) +
              lift(c, e) * determinant(e, a, b, d) - lift(d, e) * determinant(e, a, b, c));
}

class Generator {
 public:
  explicit Generator(unsigned seed) : engine_(seed) {}
  long in(long lo, long hi) { return std::uniform_int_distribution<long>(lo, hi)(engine_); }
  Grid3 point(long range) { return {in(-range, range), in(-range, range), in(-range, range)}; }

 private:
  std::mt19937_64 engine_;
};

}  // namespace

TEST_CASE("orient3d agrees with integer arithmetic, far from and near to degeneracy") {
  const unsigned seed = 20240601;
  CAPTURE(seed);
  Generator random(seed);
  int zeros = 0;
  for (int i = 0; i < 200000; ++i) {
    const long range = i % 4 == 0 ? 3 : i % 4 == 1 ? 1000 : 1L << 38;
    const Grid3 a = random.point(range), b = random.point(range), c = random.point(range);
    Grid3 d = random.point(range);
    if (i % 3 == 0) {  // in the plane of a, b, c or one step away from it
      const long s = random.in(-2, 2), t = random.in(-2, 2);
      d = {a.x + s * (b.x - a.x) + t * (c.x - a.x), a.y + s * (b.y - a.y) + t * (c.y - a.y),
           a.z + s * (b.z - a.z) + t * (c.z - a.z) + random.in(-1, 1)};
    }
    const int expected = sign(determinant(a, b, c, d));
    zeros += expected == 0;
    const double scale = std::ldexp(1.0, static_cast<int>(random.in(-60, 60)));
    const Vec3 p = a.scaled(scale), q = b.scaled(scale), r = c.scaled(scale), s = d.scaled(scale);
    REQUIRE(orient3d(p, q, r, s) == expected);
    REQUIRE(detail::orient3d_exact(p, q, r, s) == expected);
    REQUIRE(orient3d(q, p, r, s) == -expected);
    REQUIRE(orient3d(q, r, p, s) == expected);
  }
  CHECK(zeros > 1000);
}

TEST_CASE("insphere agrees with integer arithmetic, and is zero on a sphere") {
  const unsigned seed = 20240602;
  CAPTURE(seed);
  Generator random(seed);
  int zeros = 0;
  for (int i = 0; i < 100000; ++i) {
    const long range = i % 3 == 0 ? 2 : i % 3 == 1 ? 100 : 1L << 20;
    const Grid3 a = random.point(range), b = random.point(range), c = random.point(range), d = random.point(range);
    Grid3 e = random.point(range);
    if (i % 5 == 0) e = {a.x + random.in(-1, 1), a.y, a.z};
    const int expected = insphere_oracle(a, b, c, d, e);
    zeros += expected == 0;
    const double scale = std::ldexp(1.0, static_cast<int>(random.in(-40, 40)));
    const Vec3 p = a.scaled(scale), q = b.scaled(scale), r = c.scaled(scale), s = d.scaled(scale), t = e.scaled(scale);
    REQUIRE(insphere(p, q, r, s, t) == expected);
    REQUIRE(detail::insphere_exact(p, q, r, s, t) == expected);
    REQUIRE(insphere(q, p, r, s, t) == -expected);
  }
  CHECK(zeros > 500);
}

TEST_CASE("orient2d and incircle agree with integer arithmetic") {
  const unsigned seed = 20240603;
  CAPTURE(seed);
  Generator random(seed);
  for (int i = 0; i < 200000; ++i) {
    const long range = i % 3 == 0 ? 3 : i % 3 == 1 ? 1000 : 1L << 28;
    Grid3 a = random.point(range), b = random.point(range), c = random.point(range), d = random.point(range);
    a.z = b.z = c.z = d.z = 0;
    if (i % 4 == 0) c = {2 * b.x - a.x + random.in(-1, 1), 2 * b.y - a.y, 0};
    const double scale = std::ldexp(1.0, static_cast<int>(random.in(-40, 40)));
    const auto flat = [&](const Grid3& p) {
      return Vec2{scale * static_cast<double>(p.x), scale * static_cast<double>(p.y)};
    };
    const Grid3 up{a.x, a.y, a.z + 1};
    const int turn = sign(determinant(a, b, c, up));
    REQUIRE(orient2d(flat(a), flat(b), flat(c)) == turn);
    REQUIRE(detail::orient2d_exact(flat(a), flat(b), flat(c)) == turn);
    const auto minor = [&](const Grid3& p, const Grid3& q) {
      return Wide(p.x - d.x) * (q.y - d.y) - Wide(q.x - d.x) * (p.y - d.y);
    };
    const int inside = sign(lift(a, d) * minor(b, c) + lift(b, d) * minor(c, a) + lift(c, d) * minor(a, b));
    REQUIRE(incircle(flat(a), flat(b), flat(c), flat(d)) == inside);
    REQUIRE(detail::incircle_exact(flat(a), flat(b), flat(c), flat(d)) == inside);
  }
}

TEST_CASE("a positive tetrahedron holds the centre of its circumsphere") {
  const Vec3 a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0}, d{0, 0, 1};
  CHECK(orient3d(a, b, c, d) == 1);
  CHECK(insphere(a, b, c, d, {0.5, 0.5, 0.5}) == 1);
  CHECK(insphere(a, b, c, d, {2, 2, 2}) == -1);
  CHECK(insphere(a, b, c, d, {1, 1, 1}) == 0);
  CHECK(orient2d({0, 0}, {1, 0}, {0, 1}) == 1);
  CHECK(incircle({0, 0}, {1, 0}, {0, 1}, {0.5, 0.5}) == 1);
  CHECK(incircle({0, 0}, {1, 0}, {0, 1}, {1, 1}) == 0);
  CHECK(incircle({0, 0}, {1, 0}, {0, 1}, {1, 1.0000000000000002}) == -1);
}

TEST_CASE("one unit in the last place decides the sign far from the origin") {
  const double big = 1e9, next = std::nextafter(big, 2e9);
  CHECK(orient2d({0, 0}, {big, big}, {2 * big, 2 * big}) == 0);
  CHECK(orient2d({0, 0}, {big, big}, {2 * big, 2 * next}) == 1);
  CHECK(orient2d({12.0, 12.0}, {24.0, 24.0}, {0.5, 0.5 + 0x1p-53}) ==
        -orient2d({24, 24}, {12, 12}, {0.5, 0.5 + 0x1p-53}));
  CHECK(orient3d({0, 0, 0}, {big, 0, big}, {0, big, big}, {big, big, 2 * big}) == 0);
  CHECK(orient3d({0, 0, 0}, {big, 0, big}, {0, big, big}, {big, big, 2 * next}) == 1);
}

TEST_CASE("signs are exact for subnormal and huge coordinates and for both at once") {
  const double tiny = std::numeric_limits<double>::denorm_min(), huge = std::numeric_limits<double>::max();
  CHECK(orient2d({0, 0}, {tiny, 0}, {0, tiny}) == 1);
  CHECK(orient2d({0, 0}, {huge, tiny}, {-huge, tiny}) == 1);
  CHECK(orient2d({-huge, -huge}, {huge, huge}, {tiny, 0}) == -1);
  CHECK(orient2d({-huge, -huge}, {huge, huge}, {0, 0}) == 0);
  CHECK(orient3d({0, 0, 0}, {tiny, 0, 0}, {0, tiny, 0}, {0, 0, tiny}) == 1);
  CHECK(orient3d({0, 0, 0}, {tiny, 0, 0}, {0, huge, 0}, {huge, huge, -tiny}) == -1);
  CHECK(orient3d({-huge, -huge, -huge}, {huge, 0, 0}, {0, huge, 0}, {0, 0, huge}) == 1);
  CHECK(incircle({0, 0}, {tiny, 0}, {0, tiny}, {tiny, tiny}) == 0);
  CHECK(incircle({0, 0}, {huge, 0}, {0, huge}, {huge, huge}) == 0);
  CHECK(incircle({0, 0}, {huge, 0}, {0, huge}, {huge, std::nextafter(huge, 0)}) == 1);
  CHECK(insphere({0, 0, 0}, {tiny, 0, 0}, {0, tiny, 0}, {0, 0, tiny}, {tiny, tiny, tiny}) == 0);
  CHECK(insphere({0, 0, 0}, {huge, 0, 0}, {0, huge, 0}, {0, 0, huge}, {huge, huge, huge}) == 0);
  CHECK(insphere({0, 0, 0}, {huge, 0, 0}, {0, huge, 0}, {0, 0, huge}, {tiny, tiny, tiny}) == 1);
  CHECK(insphere({-huge, 0, 0}, {huge, tiny, 0}, {0, huge, 0}, {0, 0, huge}, {-huge, -tiny, 0}) == -1);
}

TEST_CASE("random signs over the whole exponent range obey the permutation laws") {
  const unsigned seed = 20240604;
  CAPTURE(seed);
  std::mt19937_64 engine(seed);
  const auto value = [&] {
    const double mantissa = std::uniform_real_distribution<double>(-1, 1)(engine);
    return std::ldexp(mantissa, std::uniform_int_distribution<int>(-1080, 1023)(engine));
  };
  for (int i = 0; i < 300; ++i) {
    std::vector<Vec3> p(5);
    for (Vec3& q : p) q = {value(), value(), value()};
    const int base = insphere(p[0], p[1], p[2], p[3], p[4]);
    const int turned = orient3d(p[0], p[1], p[2], p[3]);
    CHECK(insphere(p[1], p[0], p[2], p[3], p[4]) == -base);
    CHECK(insphere(p[1], p[2], p[0], p[3], p[4]) == base);
    CHECK(orient3d(p[1], p[0], p[2], p[3]) == -turned);
    CHECK(orient3d(p[3], p[2], p[1], p[0]) == turned);
  }
}

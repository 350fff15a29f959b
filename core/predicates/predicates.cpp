#include "core/predicates/predicates.hpp"

#include "core/predicates/integer_detail.hpp"

namespace tetloom::detail {

namespace {

// Words that a determinant of degree `degree` in differences of the coordinates may need, with room for the sums, and
// one word for the carry that scaled_integer and the sums write above the top.
int words_needed(int bits, int degree) { return (degree * (bits + 1) + 8) / 64 + 3; }

// 16 words take insphere of coordinates whose bits span 160; 180 words take all finite doubles, of 2098 bits.
constexpr int kShort = 16, kLong = 180;

template <int N>
struct Point2 {
  Integer<N> x, y;
};

template <int N>
struct Point3 {
  Integer<N> x, y, z;
};

template <int N>
Point2<N> difference(const Vec2& a, const Vec2& b, int lowest) {
  return {scaled_integer<N>(a.u, lowest) - scaled_integer<N>(b.u, lowest),
          scaled_integer<N>(a.v, lowest) - scaled_integer<N>(b.v, lowest)};
}

template <int N>
Point3<N> difference(const Vec3& a, const Vec3& b, int lowest) {
  return {scaled_integer<N>(a.x, lowest) - scaled_integer<N>(b.x, lowest),
          scaled_integer<N>(a.y, lowest) - scaled_integer<N>(b.y, lowest),
          scaled_integer<N>(a.z, lowest) - scaled_integer<N>(b.z, lowest)};
}

template <int N, class Point>
Integer<N> cross_xy(const Point& p, const Point& q) {
  return p.x * q.y - q.x * p.y;
}

template <int N>
Integer<N> determinant(const Point3<N>& p, const Point3<N>& q, const Point3<N>& r) {
  return p.z * cross_xy<N>(q, r) + q.z * cross_xy<N>(r, p) + r.z * cross_xy<N>(p, q);
}

template <int N>
Integer<N> square(const Point2<N>& p) {
  return p.x * p.x + p.y * p.y;
}

template <int N>
Integer<N> square(const Point3<N>& p) {
  return p.x * p.x + p.y * p.y + p.z * p.z;
}

template <int N>
int orient2d_sign(const Vec2& a, const Vec2& b, const Vec2& c, int lowest) {
  return cross_xy<N>(difference<N>(b, a, lowest), difference<N>(c, a, lowest)).sign();
}

template <int N>
int orient3d_sign(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, int lowest) {
  return determinant(difference<N>(b, a, lowest), difference<N>(c, a, lowest), difference<N>(d, a, lowest)).sign();
}

template <int N>
int incircle_sign(const std::array<Vec2, 4>& v, int lowest) {
  const auto p = difference<N>(v[0], v[3], lowest), q = difference<N>(v[1], v[3], lowest),
             r = difference<N>(v[2], v[3], lowest);
  return (square(p) * cross_xy<N>(q, r) + square(q) * cross_xy<N>(r, p) + square(r) * cross_xy<N>(p, q)).sign();
}

template <int N>
int insphere_sign(const std::array<Vec3, 5>& v, int lowest) {
  const auto p = difference<N>(v[0], v[4], lowest), q = difference<N>(v[1], v[4], lowest),
             r = difference<N>(v[2], v[4], lowest), s = difference<N>(v[3], v[4], lowest);
  const Integer<N> even = square(p) * determinant(q, r, s) + square(r) * determinant(p, q, s);
  const Integer<N> odd = square(q) * determinant(p, r, s) + square(s) * determinant(p, q, r);
  return (even - odd).sign();
}

}  // namespace

int orient2d_exact(const Vec2& a, const Vec2& b, const Vec2& c) {
  const BitRange range(std::array{a.u, a.v, b.u, b.v, c.u, c.v});
  if (words_needed(range.bits(), 2) <= kShort) return orient2d_sign<kShort>(a, b, c, range.lowest);
  return orient2d_sign<kLong>(a, b, c, range.lowest);
}

int orient3d_exact(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const BitRange range(std::array{a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z});
  if (words_needed(range.bits(), 3) <= kShort) return orient3d_sign<kShort>(a, b, c, d, range.lowest);
  return orient3d_sign<kLong>(a, b, c, d, range.lowest);
}

int incircle_exact(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const BitRange range(std::array{a.u, a.v, b.u, b.v, c.u, c.v, d.u, d.v});
  if (words_needed(range.bits(), 4) <= kShort) return incircle_sign<kShort>({a, b, c, d}, range.lowest);
  return incircle_sign<kLong>({a, b, c, d}, range.lowest);
}

int insphere_exact(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Vec3& e) {
  const BitRange range(std::array{a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z, e.x, e.y, e.z});
  if (words_needed(range.bits(), 5) <= kShort) return insphere_sign<kShort>({a, b, c, d, e}, range.lowest);
  return insphere_sign<kLong>({a, b, c, d, e}, range.lowest);
}

}  // namespace tetloom::detail

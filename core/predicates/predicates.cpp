#include "core/predicates/predicates.hpp"

#include <optional>

#include "core/predicates/fixed_detail.hpp"
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

// The same signs for coordinates whose differences fit in a word each once they are scaled: nothing where they do not.
// Bits at most, for differences below 2^61: minors 2^123, determinants 2^186, squares 2^124, and 2^312 for insphere.
using Word = Fixed<1>;

Fixed<2> minor(const Word& ax, const Word& ay, const Word& bx, const Word& by) { return ax * by - bx * ay; }

std::optional<int> orient2d_short(const Vec2& a, const Vec2& b, const Vec2& c) {
  std::array<Word, 4> d;
  if (!scale_differences<4>({b.u, b.v, c.u, c.v}, {a.u, a.v, a.u, a.v}, d)) return {};
  return minor(d[0], d[1], d[2], d[3]).sign();
}

std::optional<int> orient3d_short(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  std::array<Word, 9> w;
  if (!scale_differences<9>({b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z},
                            {a.x, a.y, a.z, a.x, a.y, a.z, a.x, a.y, a.z}, w))
    return {};
  const Word *p = w.data(), *q = p + 3, *r = q + 3;
  return (minor(q[0], q[1], r[0], r[1]) * p[2] + minor(r[0], r[1], p[0], p[1]) * q[2] +
          minor(p[0], p[1], q[0], q[1]) * r[2])
      .sign();
}

std::optional<int> incircle_short(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  std::array<Word, 6> w;
  if (!scale_differences<6>({a.u, a.v, b.u, b.v, c.u, c.v}, {d.u, d.v, d.u, d.v, d.u, d.v}, w)) return {};
  const Word *p = w.data(), *q = p + 2, *r = q + 2;
  const auto square = [](const Word* x) { return x[0] * x[0] + x[1] * x[1]; };
  return (square(p) * minor(q[0], q[1], r[0], r[1]) + square(q) * minor(r[0], r[1], p[0], p[1]) +
          square(r) * minor(p[0], p[1], q[0], q[1]))
      .sign();
}

std::optional<int> insphere_short(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Vec3& e) {
  std::array<Word, 12> w;
  if (!scale_differences<12>({a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z},
                             {e.x, e.y, e.z, e.x, e.y, e.z, e.x, e.y, e.z, e.x, e.y, e.z}, w))
    return {};
  const Word *p = w.data(), *q = p + 3, *r = q + 3, *s = r + 3;
  const auto xy = [](const Word* x, const Word* y) { return minor(x[0], x[1], y[0], y[1]); };
  const auto square = [](const Word* x) { return x[0] * x[0] + x[1] * x[1] + x[2] * x[2]; };
  const Fixed<2> pq = xy(p, q), qr = xy(q, r), rs = xy(r, s), sp = xy(s, p), pr = xy(p, r), qs = xy(q, s);
  const Fixed<3> pqr = qr * p[2] - pr * q[2] + pq * r[2], qrs = rs * q[2] - qs * r[2] + qr * s[2];
  const Fixed<3> rsp = sp * r[2] + pr * s[2] + rs * p[2], spq = pq * s[2] + qs * p[2] + sp * q[2];
  return ((square(p) * qrs - square(q) * rsp) + (square(r) * spq - square(s) * pqr)).sign();
}

}  // namespace

int orient2d_exact(const Vec2& a, const Vec2& b, const Vec2& c) {
  if (const std::optional<int> sign = orient2d_short(a, b, c)) return *sign;
  const BitRange range(std::array{a.u, a.v, b.u, b.v, c.u, c.v});
  if (words_needed(range.bits(), 2) <= kShort) return orient2d_sign<kShort>(a, b, c, range.lowest);
  return orient2d_sign<kLong>(a, b, c, range.lowest);
}

int orient3d_exact(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  if (const std::optional<int> sign = orient3d_short(a, b, c, d)) return *sign;
  const BitRange range(std::array{a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z});
  if (words_needed(range.bits(), 3) <= kShort) return orient3d_sign<kShort>(a, b, c, d, range.lowest);
  return orient3d_sign<kLong>(a, b, c, d, range.lowest);
}

int incircle_exact(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  if (const std::optional<int> sign = incircle_short(a, b, c, d)) return *sign;
  const BitRange range(std::array{a.u, a.v, b.u, b.v, c.u, c.v, d.u, d.v});
  if (words_needed(range.bits(), 4) <= kShort) return incircle_sign<kShort>({a, b, c, d}, range.lowest);
  return incircle_sign<kLong>({a, b, c, d}, range.lowest);
}

int insphere_exact(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Vec3& e) {
  if (const std::optional<int> sign = insphere_short(a, b, c, d, e)) return *sign;
  const BitRange range(std::array{a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z, e.x, e.y, e.z});
  if (words_needed(range.bits(), 5) <= kShort) return insphere_sign<kShort>({a, b, c, d, e}, range.lowest);
  return insphere_sign<kLong>({a, b, c, d, e}, range.lowest);
}

}  // namespace tetloom::detail

#pragma once
// Points, directions and parameter pairs. Plain values of doubles, without alignment demands, so that arrays of them
// are dense and can be handed to files and other libraries as they are.
#include <array>
#include <cmath>
#include <span>

namespace tetloom {

/// A point or direction in model space (model length units, the model's own right-handed frame).
struct Vec3 {
  double x = 0, y = 0, z = 0;

  constexpr double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  constexpr double& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  constexpr Vec3& operator+=(const Vec3& b) {
    x += b.x, y += b.y, z += b.z;
    return *this;
  }
  constexpr Vec3& operator-=(const Vec3& b) {
    x -= b.x, y -= b.y, z -= b.z;
    return *this;
  }
  constexpr Vec3& operator*=(double s) {
    x *= s, y *= s, z *= s;
    return *this;
  }
  friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
};

constexpr Vec3 operator+(Vec3 a, const Vec3& b) { return a += b; }
constexpr Vec3 operator-(Vec3 a, const Vec3& b) { return a -= b; }
constexpr Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
constexpr Vec3 operator*(double s, Vec3 a) { return a *= s; }
constexpr Vec3 operator*(Vec3 a, double s) { return a *= s; }
constexpr Vec3 operator/(Vec3 a, double s) { return {a.x / s, a.y / s, a.z / s}; }
constexpr double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
constexpr double norm2(const Vec3& a) { return dot(a, a); }
inline double norm(const Vec3& a) { return std::sqrt(norm2(a)); }
inline double distance(const Vec3& a, const Vec3& b) { return norm(a - b); }
inline bool is_finite(const Vec3& a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }
/// The unit vector along `a`; the zero vector stays zero.
inline Vec3 normalized(const Vec3& a) {
  const double length = norm(a);
  return length > 0 ? a / length : Vec3{};
}

/// A turn about the origin, then a shift.
struct RigidMotion {
  std::array<Vec3, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< what the turn makes of the unit vectors
  Vec3 shift;

  constexpr Vec3 turned(const Vec3& a) const { return a.x * axes[0] + a.y * axes[1] + a.z * axes[2]; }
  constexpr Vec3 operator()(const Vec3& p) const { return turned(p) + shift; }
  constexpr RigidMotion inverse() const {
    RigidMotion back;
    for (int i = 0; i < 3; ++i) back.axes[i] = {axes[0][i], axes[1][i], axes[2][i]};
    back.shift = -back.turned(shift);
    return back;
  }
};

/// `second` after `first`.
constexpr RigidMotion operator*(const RigidMotion& second, const RigidMotion& first) {
  return {{second.turned(first.axes[0]), second.turned(first.axes[1]), second.turned(first.axes[2])},
          second(first.shift)};
}

/// A point or direction in the parameter plane (u,v) of a model face (units of the parametrisation).
struct Vec2 {
  double u = 0, v = 0;

  constexpr Vec2& operator+=(const Vec2& b) {
    u += b.u, v += b.v;
    return *this;
  }
  constexpr Vec2& operator-=(const Vec2& b) {
    u -= b.u, v -= b.v;
    return *this;
  }
  friend constexpr bool operator==(const Vec2&, const Vec2&) = default;
};

constexpr Vec2 operator+(Vec2 a, const Vec2& b) { return a += b; }
constexpr Vec2 operator-(Vec2 a, const Vec2& b) { return a -= b; }
constexpr Vec2 operator*(double s, const Vec2& a) { return {s * a.u, s * a.v}; }
constexpr double dot(const Vec2& a, const Vec2& b) { return a.u * b.u + a.v * b.v; }
constexpr double cross(const Vec2& a, const Vec2& b) { return a.u * b.v - a.v * b.u; }
inline double norm(const Vec2& a) { return std::sqrt(dot(a, a)); }

/// An axis-aligned box; empty (lo > hi) when default-constructed.
struct Box3 {
  Vec3 lo{HUGE_VAL, HUGE_VAL, HUGE_VAL}, hi{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

  constexpr bool empty() const { return !(lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z); }
  constexpr void add(const Vec3& p) {
    for (int axis = 0; axis < 3; ++axis) {
      if (p[axis] < lo[axis]) lo[axis] = p[axis];
      if (p[axis] > hi[axis]) hi[axis] = p[axis];
    }
  }
  constexpr void add(const Box3& other) {
    if (!other.empty()) add(other.lo), add(other.hi);
  }
  double diagonal() const { return empty() ? 0 : distance(lo, hi); }
  constexpr Vec3 center() const { return 0.5 * (lo + hi); }
  constexpr bool contains(const Vec3& p) const {
    return p.x >= lo.x && p.x <= hi.x && p.y >= lo.y && p.y <= hi.y && p.z >= lo.z && p.z <= hi.z;
  }
  constexpr bool overlaps(const Box3& b) const {
    return lo.x <= b.hi.x && b.lo.x <= hi.x && lo.y <= b.hi.y && b.lo.y <= hi.y && lo.z <= b.hi.z && b.lo.z <= hi.z;
  }
};

/// Of no points: an empty box.
constexpr Box3 box_of(std::span<const Vec3> points) {
  Box3 box;
  for (const Vec3& p : points) box.add(p);
  return box;
}

}  // namespace tetloom

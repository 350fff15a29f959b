#pragma once
// How far a surface that changes has come from the given one, beside each of its vertices.
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "tetloom/vec.hpp"

namespace tetloom::features {

/// Points of the given surface that a vertex stands for now. Between vertices the surface is moved by what its vertices
/// are, interpolated, so that the largest distance at vertices bounds that of the whole surface. Points beyond a dozen
/// per vertex are forgotten, the nearest ones first.
class Displacement {
 public:
  /// All vertices stand for themselves; `points` are their places.
  explicit Displacement(std::span<const Vec3> points) : points_(points) {}

  /// The largest distance from `place` of what `v` stands for.
  double from(std::uint32_t v, const Vec3& place) const;
  /// The largest distance from `place` of what the point at the share `s` of the edge u v stands for.
  double from_edge(std::uint32_t u, std::uint32_t v, double s, const Vec3& place) const;

  /// What `gone` stands for is added to what `kept` does, which lies at `place`.
  void merge(std::uint32_t gone, std::uint32_t kept, const Vec3& place);
  /// What the point at the share `s` of the edge u v stands for is added to what `apex` does.
  void merge_edge(std::uint32_t u, std::uint32_t v, double s, std::uint32_t apex, const Vec3& place);
  /// The surface beside `kept` has been moved by as much as `distance`, by whatever is not told point by point.
  void note(std::uint32_t kept, double distance);

 private:
  struct Record {
    std::vector<Vec3> points;
    double beside = 0;  ///< moved by at least so much
  };

  std::span<const Vec3> points_of(std::uint32_t v) const;
  std::vector<Vec3> points_of_edge(std::uint32_t u, std::uint32_t v, double s) const;
  double beside(std::uint32_t v) const;
  void add(std::uint32_t v, std::span<const Vec3> more, const Vec3& place);

  std::span<const Vec3> points_;
  std::map<std::uint32_t, Record> records_;  // of vertices where something was merged
};

}  // namespace tetloom::features

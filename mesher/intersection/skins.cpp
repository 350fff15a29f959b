#include "mesher/intersection/skins.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/lists.hpp"
#include "core/predicates/predicates.hpp"

namespace tetloom {
namespace {

using Corners = std::array<Vec3, 3>;

constexpr double kParallelSkins = 0.9998;  // cosine between the normals
constexpr std::size_t kTrianglesPerItem = 4096;

class SkinSearch {
 public:
  SkinSearch(const Mesh& surface, std::span<const double> face_to_tolerance, const intersection::TriangleTree& tree)
      : mesh_(surface),
        face_to_tolerance_(face_to_tolerance),
        largest_(face_to_tolerance.empty() ? 0 : std::ranges::max(face_to_tolerance)),
        tree_(tree) {}

  /// The first triangle that faces `triangle`, in order of ids.
  std::optional<TriangleIntersection> find(std::uint32_t triangle) const {
    const Corners own = tree_.corners_of(triangle);
    const Vec3 center = (1.0 / 3) * (own[0] + own[1] + own[2]), reach{largest_, largest_, largest_};
    std::uint32_t found = kNone;
    tree_.for_each_in({center - reach, center + reach}, [&](std::uint32_t other) {
      if (other < found && faces(triangle, own, center, other)) found = other;
    });
    if (found == kNone) return {};
    const auto [first, second] = std::minmax(triangle, found);
    return TriangleIntersection{first, second, IntersectionKind::Skin, center};
  }

 private:
  double tolerance_of(std::uint32_t triangle) const { return face_to_tolerance_[mesh_.tri_to_entity[triangle]]; }

  bool faces(std::uint32_t triangle, const Corners& own, const Vec3& center, std::uint32_t other) const {
    if (other == triangle || share_a_vertex(triangle, other)) return false;
    const Corners wall = tree_.corners_of(other);
    const Vec3 normal = normalized(cross(wall[1] - wall[0], wall[2] - wall[0]));
    const double tolerance = std::max(tolerance_of(triangle), tolerance_of(other));
    if (!(std::abs(dot(normal, center - wall[0])) <= tolerance) || !lies_over(center, wall, normal)) return false;
    const double cosine = dot(normal, normalized(cross(own[1] - own[0], own[2] - own[0])));
    return std::abs(cosine) >= kParallelSkins && has_region_between(triangle, own, other, wall, cosine < 0);
  }

  bool share_a_vertex(std::uint32_t triangle, std::uint32_t other) const {
    const auto& verts = mesh_.tri_to_vert[other];
    return std::ranges::any_of(mesh_.tri_to_vert[triangle],
                               [&](std::uint32_t v) { return std::ranges::find(verts, v) != verts.end(); });
  }

  static bool lies_over(const Vec3& x, const Corners& wall, const Vec3& normal) {
    for (std::size_t i = 0; i < 3; ++i)
      if (dot(normal, cross(wall[(i + 1) % 3] - wall[i], x - wall[i])) < 0) return false;
    return true;
  }

  /// Whether one region lies on that side of either which the other one is on. `turned`: the normals are opposite.
  bool has_region_between(std::uint32_t triangle, const Corners& own, std::uint32_t other, const Corners& wall,
                          bool turned) const {
    int sum = 0;
    for (const Vec3& x : own) sum += orient3d(wall[0], wall[1], wall[2], x);
    if (sum == 0) return false;  // they cross, or lie in one plane: found by find_self_intersections
    const FaceSides& sides = mesh_.face_to_sides[mesh_.tri_to_entity[triangle]];
    const FaceSides& far = mesh_.face_to_sides[mesh_.tri_to_entity[other]];
    const ModelRegionId there = sum > 0 ? far.front : far.back;
    const ModelRegionId here = (sum > 0) == turned ? sides.front : sides.back;
    return there.valid() && here == there;
  }

  const Mesh& mesh_;
  std::span<const double> face_to_tolerance_;
  double largest_;
  const intersection::TriangleTree& tree_;
};

}  // namespace

std::vector<TriangleIntersection> find_skins(const Mesh& surface, std::span<const double> face_to_tolerance,
                                             const intersection::TriangleTree& tree, const SharedWork& work) {
  const SkinSearch search(surface, face_to_tolerance, tree);
  const std::size_t count = surface.tri_to_vert.size();
  const std::vector<double> items((count + kTrianglesPerItem - 1) / kTrianglesPerItem, 1.0);
  const auto lists = work.make_lists<TriangleIntersection>(items, [&](std::size_t item) {
    work.runner().check_cancelled();
    std::vector<TriangleIntersection> found;
    for (std::size_t t = item * kTrianglesPerItem; t < std::min(count, (item + 1) * kTrianglesPerItem); ++t)
      if (const auto skin = search.find(static_cast<std::uint32_t>(t))) found.push_back(*skin);
    return found;
  });
  std::vector<TriangleIntersection> all = joined(lists);
  const auto pair_of = [](const TriangleIntersection& hit) { return std::pair(hit.first, hit.second); };
  std::ranges::stable_sort(all, {}, pair_of);
  const auto repeated = std::ranges::unique(all, {}, pair_of);
  all.erase(repeated.begin(), repeated.end());
  return all;
}

}  // namespace tetloom

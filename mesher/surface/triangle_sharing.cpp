#include "mesher/surface/triangle_sharing.hpp"

#include <algorithm>
#include <map>
#include <numeric>

namespace tetloom {
namespace {

class Sharing {
 public:
  Sharing(const Patch& coarse, std::span<const double> weights)
      : mesh_(coarse.topology), vertices_(coarse.vertices), weights_(weights), piece_(coarse.topology.slots(), 0) {}

  std::vector<std::uint32_t> run(std::uint32_t count) {
    std::vector<std::uint32_t> triangles(mesh_.slots());
    std::iota(triangles.begin(), triangles.end(), 0u);
    bisect(triangles, 0, count);
    keep_poles_whole();
    constexpr int kPasses = 6;
    for (int pass = 0; pass < kPasses; ++pass) {
      const bool joined = join_islands();
      if (!straighten() && !joined) break;
    }
    return number_pieces();
  }

 private:
  Vec3 center(std::uint32_t tri) const {
    Vec3 sum;
    for (const std::uint32_t v : mesh_.triangle(tri)) sum += vertices_[v].place.point;
    return sum / 3.0;
  }

  // Gives the triangles to the pieces [first, first + count), as equal in weight as may be.
  void bisect(std::span<std::uint32_t> triangles, std::uint32_t first, std::uint32_t count) {
    if (count == 1 || triangles.size() < 2) {
      for (const std::uint32_t tri : triangles) piece_[tri] = first;
      return;
    }
    Box3 box;
    double total = 0;
    for (const std::uint32_t tri : triangles) {
      box.add(center(tri));
      total += weights_[tri];
    }
    const Vec3 extent = box.hi - box.lo;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    std::sort(triangles.begin(), triangles.end(), [&](std::uint32_t a, std::uint32_t b) {
      const double ca = center(a)[axis], cb = center(b)[axis];
      return ca != cb ? ca < cb : a < b;
    });
    const std::uint32_t half = count / 2;
    const double share = total * half / count;
    std::size_t cut = 0;
    for (double sum = 0; cut < triangles.size() && sum < share; ++cut) sum += weights_[triangles[cut]];
    cut = std::clamp<std::size_t>(cut, 1, triangles.size() - 1);
    bisect(triangles.first(cut), first, half);
    bisect(triangles.subspan(cut), first + half, count - half);
  }

  // No cut ends where the plane is singular: there its edges have no direction.
  void keep_poles_whole() {
    std::map<std::uint32_t, std::uint32_t> node_to_piece;
    for (std::uint32_t tri = 0; tri < mesh_.slots(); ++tri)
      for (const std::uint32_t v : mesh_.triangle(tri))
        if (vertices_[v].place.normal == Vec3{}) node_to_piece.try_emplace(vertices_[v].node, piece_[tri]);
    at_pole_.assign(mesh_.slots(), false);
    for (std::uint32_t tri = 0; tri < mesh_.slots(); ++tri)
      for (const std::uint32_t v : mesh_.triangle(tri)) {
        if (vertices_[v].place.normal != Vec3{}) continue;
        at_pole_[tri] = true;
        piece_[tri] = node_to_piece.at(vertices_[v].node);
      }
  }

  // Parts of a piece that hang on it nowhere and are small go to the neighbour with the longest border.
  bool join_islands() {
    constexpr double kSmall = 0.3;  // of the piece
    std::vector<std::uint32_t> part(mesh_.slots(), kNone);
    std::vector<std::vector<std::uint32_t>> parts;
    for (std::uint32_t tri = 0; tri < mesh_.slots(); ++tri)
      if (part[tri] == kNone) parts.push_back(collect_part(tri, static_cast<std::uint32_t>(parts.size()), part));
    std::map<std::uint32_t, double> piece_weight;
    std::vector<double> part_weight;
    for (const auto& triangles : parts) {
      double weight = 0;
      for (const std::uint32_t tri : triangles) weight += weights_[tri];
      part_weight.push_back(weight);
      piece_weight[piece_[triangles[0]]] += weight;
    }
    bool any = false;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (part_weight[i] >= kSmall * piece_weight[piece_[parts[i][0]]]) continue;
      any = hand_over(parts[i]) || any;
    }
    return any;
  }

  std::vector<std::uint32_t> collect_part(std::uint32_t start, std::uint32_t number,
                                          std::vector<std::uint32_t>& part) const {
    std::vector<std::uint32_t> triangles{start};
    part[start] = number;
    for (std::size_t k = 0; k < triangles.size(); ++k)
      for (std::uint32_t h = 3 * triangles[k]; h < 3 * triangles[k] + 3; ++h) {
        const std::uint32_t g = mesh_.twin(h);
        if (g == kNone || part[g / 3] != kNone || piece_[g / 3] != piece_[start]) continue;
        part[g / 3] = number;
        triangles.push_back(g / 3);
      }
    return triangles;
  }

  bool hand_over(const std::vector<std::uint32_t>& triangles) {
    std::map<std::uint32_t, int> borders;
    for (const std::uint32_t tri : triangles) {
      if (at_pole_[tri]) return false;
      for (std::uint32_t h = 3 * tri; h < 3 * tri + 3; ++h)
        if (mesh_.twin(h) != kNone && piece_[mesh_.twin(h) / 3] != piece_[tri]) ++borders[piece_[mesh_.twin(h) / 3]];
    }
    if (borders.empty()) return false;
    const auto longest =
        std::ranges::max_element(borders, [](const auto& a, const auto& b) { return a.second < b.second; });
    for (const std::uint32_t tri : triangles) piece_[tri] = longest->first;
    return true;
  }

  // A triangle with two sides on another piece is a tooth of the border.
  bool straighten() {
    bool any = false;
    for (std::uint32_t tri = 0; tri < mesh_.slots(); ++tri) {
      if (at_pole_[tri]) continue;
      std::array<std::uint32_t, 3> around{kNone, kNone, kNone};
      for (std::uint32_t i = 0; i < 3; ++i)
        if (mesh_.twin(3 * tri + i) != kNone) around[i] = piece_[mesh_.twin(3 * tri + i) / 3];
      for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t other = around[i];
        if (other == kNone || other == piece_[tri] || other != around[(i + 1) % 3]) continue;
        piece_[tri] = other;
        any = true;
        break;
      }
    }
    return any;
  }

  // Without gaps, in the order of their first triangles.
  std::vector<std::uint32_t> number_pieces() const {
    std::map<std::uint32_t, std::uint32_t> numbers;
    std::vector<std::uint32_t> result;
    for (const std::uint32_t piece : piece_)
      result.push_back(numbers.try_emplace(piece, static_cast<std::uint32_t>(numbers.size())).first->second);
    return result;
  }

  const Triangulation& mesh_;
  const std::vector<PatchVertex>& vertices_;
  std::span<const double> weights_;
  std::vector<std::uint32_t> piece_;  // per triangle
  std::vector<bool> at_pole_;         // per triangle
};

}  // namespace

std::vector<std::uint32_t> share_triangles(const Patch& patch, std::span<const double> weights, std::uint32_t count) {
  return Sharing(patch, weights).run(count);
}

}  // namespace tetloom

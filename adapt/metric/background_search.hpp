#pragma once
// The search for the tet that has a point, in a mesh that lies in one piece or in tiles: the same steps in the same
// order, so the same place.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "adapt/metric/background_place.hpp"
#include "core/base/mix_bits.hpp"
#include "core/tets/tet_topology.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::adapt {

/// A `Source` has
///   tet_count()       of the whole mesh
///   corners(tet)      four places
///   behind(face)      the same face of the tet behind it, not valid where there is none
///   number(tet)       which does not depend on how the source names tets
///   nearest(x)        as BoundaryTree::find_nearest, the lowest face by number of equals
template <class Source>
class BackgroundSearch {
 public:
  explicit BackgroundSearch(const Source& source) : source_(source) {}

  /// See BackgroundMesh::locate. Pre: x is finite, `start` is a tet.
  BackgroundPlace locate(const Vec3& x, BackgroundTet start) const {
    BackgroundPlace place;
    if (!walk(x, start, place)) place = locate_from_boundary(x, place.tet);
    clamp(place.weights);
    return place;
  }

 private:
  using Weights = std::array<double, 4>;

  static constexpr double kInside = -1e-12;         // a weight that counts as 0
  static constexpr std::size_t kSteepSteps = 64;    // of a walk, before it turns at random
  static constexpr std::size_t kMostVisited = 256;  // tets of a search around one

  // Negative weights become 0, and the sum 1.
  static void clamp(Weights& weights) {
    double sum = 0;
    for (double& w : weights) sum += w = std::max(w, 0.0);
    const bool fine = sum > 0 && std::isfinite(sum);  // a tet without volume says nothing
    for (double& w : weights) w = fine ? w / sum : 0.25;
  }

  static double volume6(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return dot(cross(b - a, c - a), d - a);
  }

  // Barycentric coordinates: the volumes of the tets that x makes with the faces, over their sum.
  Weights weights_in(BackgroundTet tet, const Vec3& x) const {
    const std::array<Vec3, 4> p = source_.corners(tet);
    const Vec3 a = p[0] - x, b = p[1] - x, c = p[2] - x, d = p[3] - x;
    const Vec3 ab = cross(a, b), cd = cross(c, d);
    const double wa = dot(b, cd), wb = -dot(a, cd), wc = dot(ab, d), wd = -dot(ab, c);
    const double scale = 1 / volume6(p[0], p[1], p[2], p[3]);
    return {wa * scale, wb * scale, wc * scale, wd * scale};
  }

  // True with the tet that holds x; false, with the last tet, where the walk leaves the mesh or gets nowhere.
  bool walk(const Vec3& x, BackgroundTet start, BackgroundPlace& place) const {
    const std::size_t most = 1000 + 16 * static_cast<std::size_t>(std::cbrt(static_cast<double>(source_.tet_count())));
    BackgroundTet tet = start;
    std::size_t came_through = 4;
    for (std::size_t step = 0; step < most; ++step) {
      place.tet = tet;
      place.weights = weights_in(tet, x);
      // Through the face behind which x lies farthest. Such walks may turn in circles; choosing at random ends that
      // (Devillers, Pion & Teillaud 2002), and the numbers depend on the place alone.
      const bool random = step >= kSteepSteps;
      const std::uint64_t noise = random ? mix_bits(step * 0x9e3779b97f4a7c15u ^ source_.number(tet)) : 0;
      std::size_t leave = 4;
      double steepest = kInside;
      bool outside = false;
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t i = random ? (k + noise) & 3 : k;
        if (i == came_through || !(place.weights[i] < steepest)) continue;
        outside = true;
        if (!source_.behind({tet, static_cast<std::uint32_t>(i)}).valid()) continue;
        leave = i;
        if (random) break;
        steepest = place.weights[i];
      }
      if (leave == 4) return !outside;
      const BackgroundFace next = source_.behind({tet, static_cast<std::uint32_t>(leave)});
      tet = next.tet(), came_through = next.side();
    }
    return false;
  }

  struct Candidate {
    double least;  // weight
    std::uint64_t number;
    BackgroundTet tet;
    bool operator<(const Candidate& b) const { return least != b.least ? least < b.least : number > b.number; }
  };
  Candidate candidate(BackgroundTet tet, const Vec3& x) const {
    const Weights w = weights_in(tet, x);
    return {*std::min_element(w.begin(), w.end()), source_.number(tet), tet};
  }

  // Looks at the tets around one, those in which x lies least far outside first.
  bool search_around(const Vec3& x, BackgroundTet start, BackgroundPlace& place) const {
    std::vector<Candidate> queue{candidate(start, x)};
    std::vector<BackgroundTet> seen{start};
    while (!queue.empty()) {
      std::pop_heap(queue.begin(), queue.end());
      const Candidate best = queue.back();
      queue.pop_back();
      if (best.least >= kInside) {
        place = {best.tet, weights_in(best.tet, x)};
        return true;
      }
      if (seen.size() >= kMostVisited) return false;
      for (std::uint32_t side = 0; side < 4; ++side) {
        const BackgroundFace behind = source_.behind({best.tet, side});
        if (!behind.valid() || std::find(seen.begin(), seen.end(), behind.tet()) != seen.end()) continue;
        seen.push_back(behind.tet());
        queue.push_back(candidate(behind.tet(), x));
        std::push_heap(queue.begin(), queue.end());
      }
    }
    return false;
  }

  static BackgroundPlace on_boundary(const NearestOnBoundary& nearest) {
    BackgroundPlace place{nearest.face.tet(), {}};
    for (std::size_t i = 0; i < 3; ++i)
      place.weights[tets::kFaceVerts[nearest.face.side()][i]] = nearest.point.weights[i];
    return place;
  }

  // The segment from x to the nearest point of the boundary meets the boundary nowhere else, so the tet at that point
  // is where to start looking for x, if x is inside at all.
  BackgroundPlace locate_from_boundary(const Vec3& x, BackgroundTet last) const {
    const NearestOnBoundary nearest = source_.nearest(x);
    BackgroundPlace place;
    if (!nearest.face.valid()) return {last, weights_in(last, x)};  // so far away that squares overflow
    const BackgroundTet tet = nearest.face.tet();
    const auto& p = nearest.point.weights;
    const bool beside = p[0] > 0 && p[1] > 0 && p[2] > 0;  // beside the face, not one of its edges
    if (beside && weights_in(tet, x)[nearest.face.side()] < 0) return on_boundary(nearest);
    if (walk(x, tet, place) || search_around(x, tet, place)) return place;
    return on_boundary(nearest);
  }

  const Source& source_;
};

}  // namespace tetloom::adapt

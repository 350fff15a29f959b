#include "mesher/second_order/straighten.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/mesh/curved_tet.hpp"
#include "core/tets/deep_point.hpp"

namespace tetloom::second_order {
namespace {

constexpr std::size_t kGrain = std::size_t{1} << 13;
constexpr int kRoundsOfMoving = 4;       // then mid nodes inside are pulled as well
constexpr int kHalvings = 8;             // of the interval in which the share of a displacement is sought
constexpr double kMostKept = 0.9;        // of a displacement, where pulling has not been enough before
constexpr double kLeastKept = 1.0 / 16;  // of the first displacement; less becomes none

constexpr double kNoChange = 1e-9;  // of a coefficient, by a motion as long as the edge

struct Displaced {
  std::uint32_t mid = 0;
  bool is_on_model = false;  // else inside of a region
  Vec3 first;                // displacement from the middle when it was put on the model
  Vec3 now;
};

// The mid nodes of tets that need care, and the tets at them.
class TetsAtMids {
 public:
  TetsAtMids(std::vector<std::pair<std::uint32_t, std::uint32_t>>&& pairs) : pairs_(std::move(pairs)) {
    std::ranges::sort(pairs_);
  }
  // Calls body(tet), ascending.
  template <class Body>
  void for_tets(std::uint32_t mid, const Body& body) const {
    auto at = std::ranges::lower_bound(pairs_, std::pair{mid, std::uint32_t{0}});
    for (; at != pairs_.end() && at->first == mid; ++at) body(at->second);
  }

 private:
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs_;
};

class Straightener {
 public:
  Straightener(std::span<const CurvedNode> curved, double least, Mesh& mesh, const TaskRunner& runner)
      : least_(least), mesh_(mesh), mids_(mesh), first_mid_(vertex_count(mesh)), runner_(runner) {
    for (const CurvedNode& node : curved) {
      const Vec3 away = node.on_model - middle_of_edge(mesh, node.mid);
      displaced_.push_back({node.mid, true, away, away});
      point(node.mid) = node.on_model;
    }
  }

  Straightening run() {
    find_curved_tets();
    for (int round = 0;; ++round) {
      const std::vector<std::uint32_t> bad = find_bad_tets();
      if (bad.empty()) break;
      collect_tets_at(bad);
      for (const std::uint32_t tet : bad) {
        runner_.check_cancelled();
        mend(tet, round);
      }
    }
    return conclude();
  }

 private:
  using Mids = std::array<std::uint32_t, 6>;

  Vec3& point(std::uint32_t mid) { return mesh_.points[first_mid_ + mid]; }
  bool is_inside(std::uint32_t mid) const { return mesh_.point_to_entity[first_mid_ + mid].dim == 3; }
  Mids mids_of(std::uint32_t tet) const { return mids_of_tet(mesh_, mids_, tet); }
  TetJacobian jacobian_of(std::uint32_t tet) const { return tet_jacobian(nodes_of_tet(mesh_, mids_, tet)); }
  bool is_good(std::uint32_t tet) const {
    return is_straight(tet) || least_jacobian(jacobian_of(tet), least_) >= least_;
  }
  bool is_straight(std::uint32_t tet) const { return is_straight_tet(mesh_, mids_, tet); }

  // Tets with a curved edge: those with both ends of one among their vertices.
  void find_curved_tets() {
    std::vector<std::uint8_t> is_end(first_mid_, 0), is_curved(mesh_.mid_to_vert.size(), 0);
    for (const Displaced& node : displaced_) {
      is_curved[node.mid] = 1;
      for (const std::uint32_t v : mesh_.mid_to_vert[node.mid]) is_end[v] = 1;
    }
    const auto find = [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& found) {
      for (std::size_t t = begin; t < end; ++t) {
        const auto& verts = mesh_.tet_to_vert[t];
        if (std::ranges::count_if(verts, [&](std::uint32_t v) { return is_end[v] != 0; }) < 2) continue;
        const auto tet = static_cast<std::uint32_t>(t);
        if (std::ranges::any_of(mids_of(tet), [&](std::uint32_t m) { return is_curved[m] != 0; })) found.push_back(tet);
      }
    };
    const std::vector<std::uint32_t> none;
    for (const auto& found : map_blocks(runner_, mesh_.tet_to_vert.size(), kGrain, none, find))
      curved_tets_.insert(curved_tets_.end(), found.begin(), found.end());
  }

  std::vector<std::uint32_t> find_bad_tets() const {
    const auto find = [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& found) {
      for (std::size_t i = begin; i < end; ++i)
        if (!is_good(curved_tets_[i])) found.push_back(curved_tets_[i]);
    };
    std::vector<std::uint32_t> bad;
    const std::vector<std::uint32_t> none;
    for (const auto& found : map_blocks(runner_, curved_tets_.size(), kGrain, none, find))
      bad.insert(bad.end(), found.begin(), found.end());
    return bad;
  }

  // The tets at all mid nodes of `bad`. Those at mid nodes inside become curved tets, as the nodes may move.
  void collect_tets_at(const std::vector<std::uint32_t>& bad) {
    std::vector<std::uint8_t> is_end(first_mid_, 0);
    std::vector<std::uint32_t> wanted;
    for (const std::uint32_t tet : bad) {
      for (const std::uint32_t v : mesh_.tet_to_vert[tet]) is_end[v] = 1;
      std::ranges::copy(mids_of(tet), std::back_inserter(wanted));
    }
    std::ranges::sort(wanted);
    using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
    const auto collect = [&](std::size_t begin, std::size_t end, Pairs& pairs) {
      for (std::size_t t = begin; t < end; ++t) {
        const auto& verts = mesh_.tet_to_vert[t];
        if (std::ranges::count_if(verts, [&](std::uint32_t v) { return is_end[v] != 0; }) < 2) continue;
        const auto tet = static_cast<std::uint32_t>(t);
        for (const std::uint32_t mid : mids_of(tet))
          if (std::ranges::binary_search(wanted, mid)) pairs.emplace_back(mid, tet);
      }
    };
    Pairs all;
    for (const Pairs& pairs : map_blocks(runner_, mesh_.tet_to_vert.size(), kGrain, Pairs{}, collect))
      all.insert(all.end(), pairs.begin(), pairs.end());
    for (const auto& [mid, tet] : all) curved_tets_.push_back(tet);
    std::ranges::sort(curved_tets_);
    curved_tets_.erase(std::unique(curved_tets_.begin(), curved_tets_.end()), curved_tets_.end());
    at_mids_.emplace(std::move(all));
  }

  void mend(std::uint32_t tet, int round) {
    if (is_good(tet)) return;
    if (round < kRoundsOfMoving) {
      for (const std::uint32_t mid : mids_of(tet)) {
        if (!is_inside(mid)) continue;
        move_inside(mid);
        if (is_good(tet)) return;
      }
    }
    pull(tet, round);
  }

  // Moves a mid node inside of a region to where the tets around have the largest least coefficient, or only as far on
  // the way as it takes for `least_`. Coefficients are affine in the place of one mid node.
  void move_inside(std::uint32_t mid) {
    const std::vector<tets::AffineFunction> coefficients = coefficients_at(mid);
    std::vector<tets::AffineFunction> scratch = coefficients;
    const std::optional<tets::DeepPoint> best = tets::maximize_least(scratch);
    if (!best || !is_finite(best->point)) return;
    const auto least_at = [&](double share) {
      double least = HUGE_VAL;
      for (const auto& [slope, offset] : coefficients)
        least = std::min(least, offset + share * dot(slope, best->point));
      return least;
    };
    if (!(least_at(1) > least_at(0))) return;
    double enough = 1;
    for (double step = 0.5; least_at(1) >= least_ && step > 1.0 / (1 << kHalvings); step /= 2)
      if (least_at(enough - step) >= least_) enough -= step;
    point(mid) += enough * best->point;
    remember(mid);
  }

  // The coefficients of the tets at a mid node that depend on its place, as functions of its displacement from where it
  // is.
  std::vector<tets::AffineFunction> coefficients_at(std::uint32_t mid) {
    const Vec3 here = point(mid);
    const auto [a, b] = mesh_.mid_to_vert[mid];
    const double step = distance(mesh_.points[a], mesh_.points[b]);
    std::vector<tets::AffineFunction> functions;
    at_mids_->for_tets(mid, [&](std::uint32_t tet) {
      const TetJacobian base = jacobian_of(tet);
      std::array<TetJacobian, 3> moved;
      for (int axis = 0; axis < 3; ++axis) {
        point(mid)[axis] = here[axis] + step;
        moved[static_cast<std::size_t>(axis)] = jacobian_of(tet);
        point(mid) = here;
      }
      for (std::size_t c = 0; c < base.size(); ++c) {
        const Vec3 change{moved[0][c] - base[c], moved[1][c] - base[c], moved[2][c] - base[c]};
        if (norm(change) > kNoChange) functions.push_back({change / step, base[c]});
      }
    });
    return functions;
  }

  void remember(std::uint32_t mid) {
    const auto at = std::ranges::lower_bound(displaced_, mid, {}, &Displaced::mid);
    const Vec3 now = point(mid) - middle_of_edge(mesh_, mid);
    if (at != displaced_.end() && at->mid == mid) {
      at->first = at->now = now;
    } else {
      displaced_.insert(at, {mid, false, now, now});
    }
  }

  // Takes away from the displacements of a tet's mid nodes what it takes: that of a single one, if that suffices, the
  // least change of all; otherwise all by the same share.
  void pull(std::uint32_t tet, int round) {
    std::vector<Displaced*> nodes;
    for (const std::uint32_t mid : mids_of(tet)) {
      const auto at = std::ranges::lower_bound(displaced_, mid, {}, &Displaced::mid);
      if (at != displaced_.end() && at->mid == mid && at->now != Vec3{}) nodes.push_back(&*at);
    }
    std::span<Displaced*> best = nodes;
    double best_share = 0, best_change = HUGE_VAL;
    for (Displaced*& node : nodes) {
      const std::optional<double> share = find_share(tet, {&node, 1});
      const double change = share ? (1 - *share) * norm(node->now) : HUGE_VAL;
      if (change < best_change) best = {&node, 1}, best_share = *share, best_change = change;
    }
    if (best_change == HUGE_VAL) best_share = find_share(tet, nodes).value_or(0);
    if (round >= 2 * kRoundsOfMoving) best_share = std::min(best_share, kMostKept);
    for (Displaced* node : best) {
      node->now *= best_share;
      if (norm(node->now) < kLeastKept * norm(node->first)) node->now = {};
      put(*node, 1);
    }
  }

  void put(const Displaced& node, double share) {
    const Vec3 middle = middle_of_edge(mesh_, node.mid);
    point(node.mid) = share * norm2(node.now) > 0 ? middle + share * node.now : middle;
  }

  // The largest share of the displacements of `nodes` with which the tet is good; nothing where there is none. Leaves
  // them as they were.
  std::optional<double> find_share(std::uint32_t tet, std::span<Displaced* const> nodes) {
    const auto is_good_with = [&](double share) {
      for (const Displaced* node : nodes) put(*node, share);
      return is_good(tet);
    };
    std::optional<double> found;
    if (is_good_with(0)) {
      found = 0;
      double step = 0.5;
      for (int i = 0; i < kHalvings; ++i, step /= 2)
        if (is_good_with(*found + step)) *found += step;
    }
    for (const Displaced* node : nodes) put(*node, 1);
    return found;
  }

  Straightening conclude() const {
    Straightening result;
    for (const Displaced& node : displaced_) {
      if (!node.is_on_model && node.now != Vec3{}) result.moved.push_back(node.mid);
      if (node.is_on_model && node.now != node.first)
        result.off_model.push_back({node.mid, middle_of_edge(mesh_, node.mid) + node.first});
    }
    struct Bounds {
      double least = 1;
      std::size_t not_positive = 0;
    };
    const auto bound = [&](std::size_t begin, std::size_t end, Bounds& bounds) {
      for (std::size_t i = begin; i < end; ++i) {
        if (is_straight(curved_tets_[i])) continue;
        const double least = least_jacobian(jacobian_of(curved_tets_[i]), least_);
        bounds.least = std::min(bounds.least, least);
        bounds.not_positive += least > 0 ? 0 : 1;
      }
    };
    for (const Bounds& bounds : map_blocks(runner_, curved_tets_.size(), kGrain, Bounds{}, bound)) {
      result.min_scaled_jacobian = std::min(result.min_scaled_jacobian, bounds.least);
      result.not_positive += bounds.not_positive;
    }
    return result;
  }

  double least_;
  Mesh& mesh_;
  MidNodes mids_;
  std::size_t first_mid_;
  const TaskRunner& runner_;
  std::vector<Displaced> displaced_;  // ascending by mid
  std::vector<std::uint32_t> curved_tets_;
  std::optional<TetsAtMids> at_mids_;
};

}  // namespace

Straightening straighten(std::span<const CurvedNode> curved, double least, Mesh& mesh, const TaskRunner& runner) {
  return Straightener(curved, least, mesh, runner).run();
}

}  // namespace tetloom::second_order

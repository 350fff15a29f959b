#include "mesher/second_order/straighten.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "core/base/grain.hpp"
#include "core/base/lists.hpp"
#include "core/tets/deep_point.hpp"
#include "mesher/second_order/curved_mesh.hpp"

namespace tetloom::second_order {
namespace {

constexpr int kRoundsOfMoving = 4;       // then mid nodes inside are pulled as well
constexpr int kHalvings = 8;             // of the interval in which the share of a displacement is sought
constexpr double kMostKept = 0.9;        // of a displacement, where pulling has not been enough before
constexpr double kLeastKept = 1.0 / 16;  // of the first displacement; less becomes none

constexpr double kNoChange = 1e-9;  // of a coefficient, by a motion as long as the edge

struct Displaced {
  std::uint32_t mid = 0;
  Vec3 first;  // displacement from the middle, when it was put on the model or moved
  Vec3 now;
  std::vector<Displaced> followers;  // that keep the same share of theirs
};

class Straightener {
 public:
  Straightener(std::span<const CurvedNode> curved, double least, Mesh& mesh, const TaskRunner& runner)
      : mesh_(mesh, least, runner), curved_cells_(cells_of(mesh_.cells_at(mids_of(curved)))) {
    for (const CurvedNode& node : curved)
      if (node.follows == kNone) displaced_.push_back(place(node));
    for (const CurvedNode& node : curved) {
      if (node.follows == kNone) continue;
      followed_.emplace_back(node.mid, node.follows);
      find_placed(node.follows)->followers.push_back(place(node));
    }
  }

  Straightening run(std::vector<std::uint32_t> bad) {
    for (int round = 0; !bad.empty(); ++round) {
      collect_cells_at(bad);
      for (const std::uint32_t cell : bad) {
        mesh_.runner().check_cancelled();
        mend(cell, round);
      }
      bad = find_bad();
    }
    return conclude();
  }

  std::vector<std::uint32_t> find_bad() const { return mesh_.find_bad(curved_cells_); }

  std::vector<std::uint32_t> hopeless_of(std::vector<std::uint32_t> bad) const {
    std::erase_if(bad, [&](std::uint32_t cell) { return may_be_mended_inside(cell); });
    return bad;
  }

 private:
  Displaced place(const CurvedNode& node) {
    const Vec3 away = node.place - mesh_.middle(node.mid);
    mesh_.point(node.mid) = node.place;
    return {node.mid, away, away, {}};
  }

  // The cells at all mid nodes of `bad`: they may be bad next, as nodes move. Those at displaced nodes, and at what
  // follows them, are there from the beginning.
  void collect_cells_at(const std::vector<std::uint32_t>& bad) {
    std::vector<std::uint32_t> wanted;
    for (const std::uint32_t cell : bad) std::ranges::copy(mesh_.mids_of(cell), std::back_inserter(wanted));
    sort_unique(wanted);
    at_mids_ = mesh_.cells_at(wanted);
    std::vector<std::uint32_t> all;
    std::ranges::set_union(curved_cells_, cells_of(at_mids_), std::back_inserter(all));
    curved_cells_ = std::move(all);
  }

  void mend(std::uint32_t cell, int round) {
    if (mesh_.is_good(cell)) return;
    if (round < kRoundsOfMoving && mesh_.is_tet(cell) && may_be_mended_inside(cell)) {
      for (const std::uint32_t mid : mesh_.mids_of(cell)) {
        if (!mesh_.is_free(mid)) continue;
        move_inside(mid);
        if (mesh_.is_good(cell)) return;
      }
    }
    pull(cell, round);
  }

  // False where the Jacobian at a vertex is too small whose mid nodes are all on the surface, as between two faces on
  // one smooth surface: the tangents of three edges lie in one plane there.
  bool may_be_mended_inside(std::uint32_t tet) const {
    const CellMids mids = mesh_.mids_of(tet);
    std::array<bool, 4> is_fixed{true, true, true, true};
    for (std::size_t e = 0; e < mids.size(); ++e)
      if (mesh_.is_free(mids[e]))
        for (const std::uint8_t v : shape_of(CellKind::Tet).edge[e]) is_fixed[v] = false;
    const TetJacobian jacobian = mesh_.jacobian_of(tet);
    for (std::size_t v = 0; v < is_fixed.size(); ++v)
      if (is_fixed[v] && jacobian[v] < mesh_.least()) return false;
    return true;
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
    for (double step = 0.5; least_at(1) >= mesh_.least() && step > 1.0 / (1 << kHalvings); step /= 2)
      if (least_at(enough - step) >= mesh_.least()) enough -= step;
    mesh_.point(mid) += enough * best->point;
    remember(mid);
  }

  // The coefficients of the tets at a mid node that depend on its place, as functions of its displacement from where it
  // is.
  std::vector<tets::AffineFunction> coefficients_at(std::uint32_t mid) {
    const Vec3 here = mesh_.point(mid);
    const auto [a, b] = mesh_.mesh().mid_to_vert[mid];
    const double step = distance(mesh_.mesh().points[a], mesh_.mesh().points[b]);
    std::vector<tets::AffineFunction> functions;
    const auto first = std::ranges::lower_bound(at_mids_, MidAndCell{mid, 0});
    for (auto at = first; at != at_mids_.end() && at->first == mid; ++at) {
      const TetJacobian base = mesh_.jacobian_of(at->second);
      std::array<TetJacobian, 3> moved;
      for (int axis = 0; axis < 3; ++axis) {
        mesh_.point(mid)[axis] = here[axis] + step;
        moved[static_cast<std::size_t>(axis)] = mesh_.jacobian_of(at->second);
        mesh_.point(mid) = here;
      }
      for (std::size_t c = 0; c < base.size(); ++c) {
        const Vec3 change{moved[0][c] - base[c], moved[1][c] - base[c], moved[2][c] - base[c]};
        if (norm(change) > kNoChange) functions.push_back({change / step, base[c]});
      }
    }
    return functions;
  }

  void remember(std::uint32_t mid) {
    const Vec3 now = mesh_.point(mid) - mesh_.middle(mid);
    moved_.insert_or_assign(mid, Displaced{mid, now, now, {}});
  }

  // One that follows nothing. Null where there is none.
  Displaced* find_placed(std::uint32_t mid) {
    const auto at = std::ranges::lower_bound(displaced_, mid, {}, &Displaced::mid);
    return at == displaced_.end() || at->mid != mid ? nullptr : &*at;
  }

  // What the mid node moves with. Null where it has always been in the middle.
  Displaced* find_displaced(std::uint32_t mid) {
    if (mesh_.is_free(mid)) {
      const auto at = moved_.find(mid);
      if (at != moved_.end()) return &at->second;
    }
    const auto at = std::ranges::lower_bound(followed_, mid, {}, &std::pair<std::uint32_t, std::uint32_t>::first);
    return find_placed(at == followed_.end() || at->first != mid ? mid : at->second);
  }

  // Takes away from the displacements of a cell's mid nodes what it takes: that of a single one, if that suffices, the
  // least change of all; otherwise all by the same share.
  void pull(std::uint32_t cell, int round) {
    std::vector<Displaced*> nodes;
    for (const std::uint32_t mid : mesh_.mids_of(cell)) {
      Displaced* node = find_displaced(mid);
      if (node && node->now != Vec3{} && std::ranges::find(nodes, node) == nodes.end()) nodes.push_back(node);
    }
    std::span<Displaced*> best = nodes;
    double best_share = 0, best_change = HUGE_VAL;
    for (Displaced*& node : nodes) {
      const std::optional<double> share = find_share(cell, {&node, 1});
      const double change = share ? (1 - *share) * norm(node->now) : HUGE_VAL;
      if (change < best_change) best = {&node, 1}, best_share = *share, best_change = change;
    }
    if (best_change == HUGE_VAL) best_share = find_share(cell, nodes).value_or(0);
    if (round >= 2 * kRoundsOfMoving) best_share = std::min(best_share, kMostKept);
    for (Displaced* node : best) {
      node->now *= best_share;
      const bool is_small = norm(node->now) < kLeastKept * norm(node->first);
      if (is_small) node->now = {};
      for (Displaced& follower : node->followers) follower.now = is_small ? Vec3{} : best_share * follower.now;
      put(*node, 1);
    }
  }

  void put(const Displaced& node, double share) {
    const Vec3 middle = mesh_.middle(node.mid);
    mesh_.point(node.mid) = share * norm2(node.now) > 0 ? middle + share * node.now : middle;
    for (const Displaced& follower : node.followers) put(follower, share);
  }

  // The largest share of the displacements of `nodes` with which the cell is good; nothing where there is none. Leaves
  // them as they were.
  std::optional<double> find_share(std::uint32_t cell, std::span<Displaced* const> nodes) {
    const auto is_good_with = [&](double share) {
      for (const Displaced* node : nodes) put(*node, share);
      return mesh_.is_good(cell);
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

  void note(const Displaced& node, Straightening& result) const {
    if (mesh_.is_on_surface(node.mid) && node.now != node.first)
      result.off_model.push_back({node.mid, mesh_.middle(node.mid) + node.first, kNone});
    if (!mesh_.is_on_surface(node.mid) && node.now != Vec3{}) result.moved.push_back(node.mid);
    for (const Displaced& follower : node.followers) note(follower, result);
  }

  Straightening conclude() const {
    Straightening result;
    for (const auto& [mid, node] : moved_) note(node, result);
    for (const Displaced& node : displaced_) note(node, result);
    std::ranges::sort(result.moved);
    std::ranges::sort(result.off_model, {}, &CurvedNode::mid);
    struct Bounds {
      double least = 1;
      std::size_t not_positive = 0;
    };
    const auto bound = [&](std::size_t begin, std::size_t end, Bounds& bounds) {
      for (std::size_t i = begin; i < end; ++i) {
        if (mesh_.is_straight(curved_cells_[i])) continue;
        const double least = mesh_.least_jacobian_of(curved_cells_[i]);
        bounds.least = std::min(bounds.least, least);
        bounds.not_positive += least > 0 ? 0 : 1;
      }
    };
    for (const Bounds& bounds : map_blocks(mesh_.runner(), curved_cells_.size(), kElementGrain, Bounds{}, bound)) {
      result.min_scaled_jacobian = std::min(result.min_scaled_jacobian, bounds.least);
      result.not_positive += bounds.not_positive;
    }
    return result;
  }

  CurvedMesh mesh_;
  std::vector<Displaced> displaced_;  // ascending by mid; those put in their places at first
  std::vector<std::pair<std::uint32_t, std::uint32_t>> followed_;  // ascending; mid nodes, and what they follow
  std::map<std::uint32_t, Displaced> moved_;                       // by mid; those free to move
  std::vector<std::uint32_t> curved_cells_;                        // ascending; those that may be bad
  std::vector<MidAndCell> at_mids_;                                // ascending; of the mid nodes of bad cells
};

}  // namespace

Straightening straighten(std::span<const CurvedNode> curved, double least, Mesh& mesh, const TaskRunner& runner) {
  Straightener straightener(curved, least, mesh, runner);
  return straightener.run(straightener.find_bad());
}

std::optional<Straightening> straighten_unless_hopeless(std::span<const CurvedNode> curved, double least, Mesh& mesh,
                                                        std::vector<std::uint32_t>& hopeless,
                                                        const TaskRunner& runner) {
  Straightener straightener(curved, least, mesh, runner);
  std::vector<std::uint32_t> bad = straightener.find_bad();
  hopeless = straightener.hopeless_of(bad);
  if (!hopeless.empty()) return std::nullopt;
  return straightener.run(std::move(bad));
}

}  // namespace tetloom::second_order

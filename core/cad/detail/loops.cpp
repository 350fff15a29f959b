#include "core/cad/detail/loops.hpp"

#include <algorithm>
#include <numbers>
#include <optional>

namespace tetloom::cad {
namespace {

/// Share of the parameter box within which two ends at one vertex count as the same place: far more than the gaps of
/// sloppy files, far less than the distance between the two sides of a seam.
constexpr double kSamePlace = 0.02;

/// How far right `out` turns from the way back along `in`, in (0, 2π]: small is a sharp turn to the left.
double turn(const Vec2& in, const Vec2& out) {
  const Vec2 back = -1.0 * in;
  const double clockwise = std::atan2(-cross(back, out), dot(back, out));
  constexpr double straight_back = 1e-7;  // running back along the same edge comes last
  return clockwise > straight_back ? clockwise : clockwise + 2 * std::numbers::pi;
}

class Chainer {
 public:
  explicit Chainer(const std::vector<LoopPiece>& pieces) : pieces_(pieces), used_(pieces.size(), false) {}

  ChainedLoops run() {
    ChainedLoops result;
    for (std::size_t i = 0; i < pieces_.size(); ++i)
      if (!used_[i]) follow(i, result);
    return result;
  }

 private:
  void follow(std::size_t first, ChainedLoops& result) {
    std::vector<std::size_t> chain{first};
    used_[first] = true;
    for (;;) {
      const std::optional<std::size_t> next = successor(pieces_[chain.back()], first);
      if (!next) {
        for (const std::size_t i : chain) result.open.push_back(pieces_[i]);
        return;
      }
      if (*next == first) break;
      used_[*next] = true;
      chain.push_back(*next);
    }
    ModelLoop& loop = result.loops.emplace_back();
    for (const std::size_t i : chain) loop.push_back(pieces_[i].use);
  }

  std::optional<std::size_t> successor(const LoopPiece& piece, std::size_t first) const {
    double nearest = HUGE_VAL;
    for (std::size_t i = 0; i < pieces_.size(); ++i)
      if (may_follow(piece, i, first)) nearest = std::min(nearest, gap(piece, i));
    std::optional<std::size_t> best;
    double best_turn = HUGE_VAL;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      if (!may_follow(piece, i, first) || gap(piece, i) > std::max(kSamePlace, 2 * nearest)) continue;
      const double angle = turn(piece.tangent_end, pieces_[i].tangent_start);
      if (angle < best_turn) best = i, best_turn = angle;
    }
    return best;
  }

  bool may_follow(const LoopPiece& piece, std::size_t i, std::size_t first) const {
    return (!used_[i] || i == first) && pieces_[i].start == piece.end;
  }
  double gap(const LoopPiece& piece, std::size_t i) const { return norm(pieces_[i].uv_start - piece.uv_end); }

  const std::vector<LoopPiece>& pieces_;
  std::vector<bool> used_;
};

}  // namespace

ChainedLoops chain_loops(const std::vector<LoopPiece>& pieces) { return Chainer(pieces).run(); }

}  // namespace tetloom::cad

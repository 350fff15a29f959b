#include "mesher/tets/relaxation.hpp"

#include <algorithm>

#include "core/tets/circumsphere.hpp"
#include "core/tets/tet_quality.hpp"
#include "mesher/tets/delaunay_flips.hpp"

namespace tetloom::tets {

namespace {

constexpr int kRelaxationRounds = 14;
constexpr double kMomentum = 0.85;
constexpr std::uint32_t kRelaxationBlock = 1 << 16;

enum class State : std::uint8_t { Stays, Moves, GoesBack };

// What a point gathers from its tets; then where it was.
struct StarMoment {
  Vec3 moment;
  double weight = 0;
};

class Relaxation {
 public:
  Relaxation(WorkingMesh& mesh, std::uint32_t first, const SizeField& sizes, const TaskRunner& runner)
      : mesh_(mesh), first_(first), runner_(runner) {
    const std::size_t points = mesh.mesh().points.size();
    state_.resize(points, State::Moves);
    last_step_.resize(points, Vec3{});
    for (std::uint32_t v = 0; v < points; ++v)
      if (mesh.is_fixed_point(v)) state_[v] = State::Stays;
    for (std::uint32_t tet = 0; tet < first; ++tet)
      for (const std::uint32_t v : mesh.verts(tet)) state_[v] = State::Stays;
    find_densities(sizes);
  }

  // Returns the number of moves.
  std::size_t move_all(double floor) {
    gather();
    step();
    quality_ = GrowingArray<float>(mesh_.qualities());
    for (bool first_look = true; put_back_where_poor(floor, first_look);) first_look = false;
    std::copy(quality_.begin(), quality_.end(), mesh_.qualities().begin());
    std::size_t moves = 0;
    for (std::size_t v = 0; v < state_.size(); ++v) {
      const bool moved = state_[v] == State::Moves;
      last_step_[v] = moved ? mesh_.mesh().points[v] - sums_[v].moment : Vec3{};
      moves += moved;
    }
    return moves;
  }

 private:
  template <class Visit>
  void for_each_tet(const Visit& visit) const {
    const auto count = static_cast<std::uint32_t>(mesh_.mesh().size());
    for (std::uint32_t tet = first_; tet < count; ++tet)
      if (!mesh_.mesh().is_dead(tet)) visit(tet);
  }

  // A vertex keeps the density of where it was first: sizes vary little over what it moves.
  void find_densities(const SizeField& sizes) {
    density_.resize(state_.size(), 0);
    for_each_tet([&](std::uint32_t tet) {
      for (const std::uint32_t v : mesh_.verts(tet)) {
        if (density_[v] > 0) continue;
        const double size = sizes.size_at(mesh_.point(v)) / sizes.largest();
        density_[v] = static_cast<float>(1 / (size * size * size * size));
      }
    });
  }

  Circumsphere sphere_of(std::uint32_t tet) const {
    const auto v = mesh_.verts(tet);
    return {mesh_.point(v[0]), mesh_.point(v[1]), mesh_.point(v[2]), mesh_.point(v[3])};
  }

  void gather() {
    runner_.check_cancelled();
    sums_.resize_for_overwrite(state_.size());
    std::fill(sums_.begin(), sums_.end(), StarMoment{});
    for_each_tet([&](std::uint32_t tet) {
      const Circumsphere sphere = sphere_of(tet);
      double density = 0;
      for (const std::uint32_t v : mesh_.verts(tet)) density += density_[v];
      const double weight = density * sphere.volume;
      const Vec3 moment = weight * sphere.corner + 0.5 * density * sphere.twice_moment;
      for (const std::uint32_t v : mesh_.verts(tet)) sums_[v].moment += moment, sums_[v].weight += weight;
    });
  }

  void step() {
    GrowingArray<Vec3>& points = mesh_.mesh().points;
    for (std::size_t v = 0; v < points.size(); ++v) {
      if (state_[v] == State::Stays) continue;
      const Vec3 before = points[v], to = sums_[v].moment / sums_[v].weight;
      state_[v] = is_finite(to) ? State::Moves : State::Stays;
      if (is_finite(to)) points[v] = to + kMomentum * last_step_[v];
      sums_[v].moment = before;
    }
  }

  // One look at the tets that have moved, or of which a vertex has gone back since. False when none was too poor.
  bool put_back_where_poor(double floor, bool first_look) {
    bool any = false;
    for_each_tet([&](std::uint32_t tet) {
      const auto v = mesh_.verts(tet);
      const auto goes_back = [&](std::uint32_t vert) { return state_[vert] == State::GoesBack; };
      if (!first_look && std::none_of(v.begin(), v.end(), goes_back)) return;
      const double now = cubed_quality(mesh_.point(v[0]), mesh_.point(v[1]), mesh_.point(v[2]), mesh_.point(v[3]));
      quality_[tet] = static_cast<float>(now);
      if (now > kSurelyPositive && (now >= floor || quality_[tet] >= mesh_.quality(tet))) return;
      for (const std::uint32_t vert : v) {
        if (state_[vert] != State::Moves) continue;
        state_[vert] = State::GoesBack;
        mesh_.mesh().points[vert] = sums_[vert].moment;
        any = true;
      }
    });
    return any;
  }

  WorkingMesh& mesh_;
  std::uint32_t first_;
  const TaskRunner& runner_;
  GrowingArray<float> density_;  // of points, those of the largest size 1
  GrowingArray<State> state_;
  GrowingArray<StarMoment> sums_;
  GrowingArray<Vec3> last_step_;
  GrowingArray<float> quality_;  // of tets, as they have moved
};

}  // namespace

std::size_t relax(WorkingMesh& mesh, std::uint32_t first, const SizeField& sizes, double floor,
                  const TaskRunner& runner) {
  Relaxation relaxation(mesh, first, sizes, runner);
  std::size_t moves = 0;
  for (int round = 0; round < kRelaxationRounds; ++round) {
    moves += relaxation.move_all(floor);
    flip_to_delaunay(mesh, first, floor, runner);
  }
  return moves;
}

}  // namespace tetloom::tets

#include "mesher/parts/gather_parts.hpp"

#include <algorithm>
#include <new>

#include "core/base/mix_bits.hpp"
#include "mesher/tets/triangle_verts.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;
using tets::TetMesh;

constexpr double kReachInEdges = 6;

std::uint64_t name_of(std::array<VertKey, 3> keys) {
  std::sort(keys.begin(), keys.end());
  std::uint64_t name = 0;
  for (const VertKey key : keys) name = mix_bits(name * 0x9e3779b97f4a7c15u + key);
  return name;
}

// Vertices of one maker: where each stands in the whole, and which part writes it down.
struct Made {
  std::vector<std::uint32_t> to_user;  // kNone: no tet has it any more
  std::vector<std::uint32_t> to_whole;
};

class Gatherer {
 public:
  Gatherer(std::span<const Vec3> given, std::span<PartState* const> states, const TaskRunner& runner)
      : states_(states), runner_(runner), given_(given) {}

  volume::Filling run() {
    find_users();
    std::size_t tets = 0;
    for (const PartState* state : states_) {
      first_tet_.push_back(tets);
      tets += state->mesh.size();
    }
    number_points();
    volume::Filling filling;
    filling.points.resize(point_count_);
    std::copy(given_.begin(), given_.end(), filling.points.begin());
    for (const PartState* state : states_)
      for (const MovedPoint& moved : state->moved_points) filling.points[moved.point] = moved.to;
    filling.tet_to_vert.resize(tets);
    filling.tet_to_region.resize(tets);
    runner_.for_each(states_.size(), [&](std::size_t p) { write(p, filling); });
    return filling;
  }

 private:
  // A part says which vertices it uses; whoever made them hears it.
  void find_users() {
    made_.resize(states_.size());
    std::vector<std::vector<std::vector<VertKey>>> user_to_foreign(states_.size());
    runner_.for_each(states_.size(), [&](std::size_t p) {
      const PartState& state = *states_[p];
      std::vector<char> used(state.keys.size(), 0);
      for (const std::uint32_t v : state.mesh.to_vert) used[v] = 1;
      made_[p].to_user.assign(state.next_index, kNone);
      auto& foreign = user_to_foreign[p];
      foreign.resize(states_.size());
      for (std::size_t v = 0; v < used.size(); ++v) {
        const VertKey key = state.keys[v];
        if (!used[v] || is_of_surface(key)) continue;
        const std::size_t maker = maker_of(key).value;
        if (maker == p) {
          made_[p].to_user[static_cast<std::uint32_t>(key)] = static_cast<std::uint32_t>(p);
        } else {
          foreign[maker].push_back(key);
        }
      }
    });
    runner_.for_each(states_.size(), [&](std::size_t p) {
      for (std::size_t user = 0; user < states_.size(); ++user) {
        for (const VertKey key : user_to_foreign[user][p]) {
          std::uint32_t& first = made_[p].to_user[static_cast<std::uint32_t>(key)];
          if (first == kNone) first = static_cast<std::uint32_t>(user);
        }
      }
    });
  }

  void number_points() {
    std::vector<std::size_t> counts(states_.size());
    runner_.for_each(states_.size(), [&](std::size_t p) {
      const auto& users = made_[p].to_user;
      counts[p] = users.size() - static_cast<std::size_t>(std::count(users.begin(), users.end(), kNone));
    });
    point_count_ = given_.size();
    std::vector<std::size_t> first;
    for (const std::size_t count : counts) {
      first.push_back(point_count_);
      point_count_ += count;
    }
    if (point_count_ >= kNone) throw std::bad_alloc();
    runner_.for_each(states_.size(), [&](std::size_t p) {
      auto next = static_cast<std::uint32_t>(first[p]);
      Made& made = made_[p];
      made.to_whole.resize(made.to_user.size());
      for (std::size_t i = 0; i < made.to_user.size(); ++i)
        made.to_whole[i] = made.to_user[i] == kNone ? kNone : next++;
    });
  }

  void write(std::size_t p, volume::Filling& filling) {
    PartState& state = *states_[p];
    TetMesh& mesh = state.mesh;
    std::vector<std::uint32_t> to_whole(state.keys.size());
    for (std::size_t v = 0; v < to_whole.size(); ++v) {
      const VertKey key = state.keys[v];
      const auto index = static_cast<std::uint32_t>(key);
      if (is_of_surface(key)) {
        to_whole[v] = index;
        continue;
      }
      const Made& made = made_[maker_of(key).value];
      to_whole[v] = made.to_whole[index];
      if (made.to_user[index] == p && to_whole[v] != kNone) filling.points[to_whole[v]] = mesh.points[v];
    }
    mesh.points.release(), mesh.to_neighbor.release(), mesh.to_fixed.release(), state.keys.release();
    for (std::size_t tet = 0; tet < mesh.to_region.size(); ++tet) {
      for (std::size_t i = 0; i < 4; ++i)
        filling.tet_to_vert[first_tet_[p] + tet][i] = to_whole[mesh.to_vert[tet * 4 + i]];
      filling.tet_to_region[first_tet_[p] + tet] = mesh.to_region[tet];
    }
    state = PartState();
  }

  std::span<PartState* const> states_;
  const TaskRunner& runner_;
  std::span<const Vec3> given_;
  std::vector<Made> made_;
  std::vector<std::size_t> first_tet_;
  std::size_t point_count_ = 0;
};

}  // namespace

void name_open_faces(PartState& state) {
  const TetMesh& mesh = state.mesh;
  state.open_names.clear();
  for (const FaceCode face : state.open_faces) {
    const auto [a, b, c] = verts_of(mesh, face);
    state.open_names.push_back(name_of({state.keys[a], state.keys[b], state.keys[c]}));
  }
}

std::vector<std::uint64_t> open_faces_near(const PartState& state, const Box3& box) {
  const TetMesh& mesh = state.mesh;
  std::vector<std::uint64_t> near;
  for (std::size_t i = 0; i < state.open_faces.size(); ++i) {
    const auto [a, b, c] = verts_of(mesh, state.open_faces[i]);
    const double length = std::max(distance(mesh.points[a], mesh.points[b]), distance(mesh.points[a], mesh.points[c]));
    if (distance_outside(mesh.points[a], box) <= kReachInEdges * length) near.push_back(state.open_names[i]);
  }
  return near;
}

void check_open_faces(PartState& state, std::span<const std::span<const std::uint64_t>> told) {
  std::sort(state.open_names.begin(), state.open_names.end());
  std::vector<std::uint8_t> met(state.open_names.size(), 0);
  for (const auto& names : told) {
    for (const std::uint64_t name : names) {
      const auto at = std::lower_bound(state.open_names.begin(), state.open_names.end(), name);
      if (at == state.open_names.end() || *at != name) continue;
      std::uint8_t& count = met[static_cast<std::size_t>(at - state.open_names.begin())];
      count = static_cast<std::uint8_t>(std::min(2, count + 1));
    }
  }
  for (std::size_t i = 0; i < met.size(); ++i) {
    if (met[i] == 0) state.unmet_names.push_back(state.open_names[i]);
    if (met[i] > 1) state.fault.message = "three parts have the same face";
  }
}

volume::Filling gather_parts(std::span<const Vec3> given, std::span<PartState* const> states,
                             const TaskRunner& runner) {
  return Gatherer(given, states, runner).run();
}

}  // namespace tetloom::parts

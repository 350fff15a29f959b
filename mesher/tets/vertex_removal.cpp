#include "mesher/tets/vertex_removal.hpp"

#include <algorithm>

#include "mesher/tets/bad_tets.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

namespace {

// The tet at `code` with its vertex there replaced.
std::array<std::uint32_t, 4> with_vertex(const WorkingMesh& mesh, FaceCode code, std::uint32_t vertex) {
  const auto verts = mesh.verts(code.tet());
  std::array<std::uint32_t, 4> result{verts[0], verts[1], verts[2], verts[3]};
  result[code.side()] = vertex;
  return result;
}

bool has_vertex(const WorkingMesh& mesh, std::uint32_t tet, std::uint32_t vertex) {
  const auto verts = mesh.verts(tet);
  return std::find(verts.begin(), verts.end(), vertex) != verts.end();
}

double quality_of(const WorkingMesh& mesh, const std::array<std::uint32_t, 4>& v) {
  return cubed_quality(mesh.point(v[0]), mesh.point(v[1]), mesh.point(v[2]), mesh.point(v[3]));
}

}  // namespace

// The minimum after merging into `target`; something not above `goal` as soon as that is certain.
double VertexRemover::least_with(std::uint32_t target, double goal) const {
  double least = 1;
  for (const FaceCode code : star_.tets()) {
    if (has_vertex(mesh_, code.tet(), target)) continue;
    least = std::min(least, quality_of(mesh_, with_vertex(mesh_, code, target)));
    if (least <= goal) break;
  }
  return least;
}

void VertexRemover::try_star() {
  float before = 1;
  for (const FaceCode code : star_.tets()) before = std::min(before, mesh_.quality(code.tet()));
  double goal = std::max({best_, before * kGain, kSurelyPositive});
  for (const FaceCode code : star_.tets()) {
    for (const std::uint32_t target : mesh_.verts(code.tet())) {
      if (target == star_.vertex || target == best_target_) continue;
      const double least = least_with(target, goal);
      if (least <= goal) continue;
      goal = best_ = least;
      best_target_ = target;
      best_star_ = star_;
    }
  }
}

void VertexRemover::apply() {
  std::array<std::uint32_t, WorkingMesh::kMostTets> old;
  std::array<NewTet, WorkingMesh::kMostTets> made;
  std::size_t made_count = 0;
  for (std::size_t i = 0; i < best_star_.count; ++i) {
    const FaceCode code = best_star_.codes[i];
    old[i] = code.tet();
    if (has_vertex(mesh_, code.tet(), best_target_)) continue;
    const auto verts = with_vertex(mesh_, code, best_target_);
    made[made_count++] = {verts, quality_of(mesh_, verts)};
  }
  mesh_.replace(std::span(old).first(best_star_.count), std::span(made).first(made_count));
  mesh_.give_up_point(best_star_.vertex);
}

bool VertexRemover::remove_vertex_of(std::uint32_t tet) {
  best_target_ = kNone;
  best_ = mesh_.quality(tet) * kGain;
  for (std::uint32_t corner = 0; corner < 4; ++corner) {
    if (find_star(mesh_, tet, corner, star_) == StarVerdict::Found) try_star();
  }
  if (best_target_ == kNone) return false;
  apply();
  return true;
}

std::size_t remove_vertices(WorkingMesh& mesh, double limit, const TaskRunner& runner) {
  VertexRemover remover(mesh);
  std::size_t count = 0;
  for_each_bad_tet(mesh, limit, runner, [&](std::uint32_t tet) { count += remover.remove_vertex_of(tet); });
  return count;
}

}  // namespace tetloom::tets

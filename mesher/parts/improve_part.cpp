#include "mesher/parts/improve_part.hpp"

#include <algorithm>
#include <utility>

#include "core/base/lists.hpp"
#include "core/tets/many_values.hpp"
#include "core/tets/tet_quality.hpp"
#include "core/tets/triangle_verts.hpp"
#include "mesher/intersection/triangle_tree.hpp"
#include "mesher/tets/quality_summary.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;
using tets::TetMesh;
using tets::TriangleVerts;
using volume::Complex;

// In sizes. Tets between two boxes are mostly of the part with the lower number, which so may change points beside its
// box. Others stay away from there: triangles at two points that change must not meet.
constexpr double kBesideBox = 1, kFromOtherBoxes = 3;

class Improvement {
 public:
  Improvement(const SharedInput& input, PartTets& part_tets, tets::OptimizeReport& report, PartId part)
      : input_(input),
        tets_(part_tets),
        mesh_(part_tets.mesh),
        report_(report),
        box_(input.decomposition.box(part)),
        part_(part) {}

  std::vector<ChangedTriangle> run(std::span<const std::uint32_t> elsewhere, const TaskRunner& runner) {
    collect();
    renumber();
    freeze(elsewhere);
    const intersection::TriangleTree tree(surface_.points, surface_.tri_to_vert, runner);
    tets::OptimizeOptions options = optimize_options(input_.filling);
    options.fixed_points = static_cast<std::uint32_t>(surface_.points.size());
    options.keep_points = true;
    const auto after =
        volume::improve(mesh_, {surface_, tree, *input_.filling.freedom, options, is_frozen_}, report_, runner);
    while (tets_.keys.size() < mesh_.points.size()) tets_.keys.push_back(key_of(part_, tets_.next_index++));
    return find_changes(after);
  }

 private:
  // The surface that the part knows or has tets at, with numbers of its own.
  void collect() {
    triangles_ = tets_.triangles;
    for (const FaceCode face : mesh_.faces()) {
      if (!mesh_.is_fixed(face)) continue;
      if (const auto triangle = input_.triangles.find(tets::sorted(complex_verts(face))))
        triangles_.push_back(*triangle);
    }
    sort_unique(triangles_);
    const Complex& complex = input_.filling.complex;
    for (const std::uint32_t t : triangles_)
      points_.insert(points_.end(), complex.tri_to_vert[t].begin(), complex.tri_to_vert[t].end());
    for (const VertKey key : tets_.keys)
      if (is_of_surface(key)) points_.push_back(static_cast<std::uint32_t>(key));
    sort_unique(points_);
    for (const std::uint32_t point : points_) {
      arrays_.points.push_back(complex.points[point]);
      arrays_.to_input_vert.push_back(complex.to_input_vert[point]);
    }
    for (const std::uint32_t t : triangles_) {
      const auto& [a, b, c] = complex.tri_to_vert[t];
      arrays_.tri_to_vert.push_back({local(a), local(b), local(c)});
      arrays_.tri_to_sides.push_back(complex.tri_to_sides[t]);
      arrays_.to_input_tri.push_back(complex.to_input_tri[t]);
    }
    surface_ = arrays_.view(complex.regions);
  }

  TriangleVerts complex_verts(FaceCode face) const {
    TriangleVerts verts = verts_of(mesh_, face);
    for (std::uint32_t& v : verts) v = static_cast<std::uint32_t>(tets_.keys[v]);
    return verts;
  }

  std::uint32_t local(std::uint32_t point) const {
    return static_cast<std::uint32_t>(std::lower_bound(points_.begin(), points_.end(), point) - points_.begin());
  }

  // Points of the surface first, as in surface_.
  void renumber() {
    GrowingArray<Vec3> points{surface_.points};
    GrowingArray<VertKey> keys;
    for (const std::uint32_t point : points_) keys.push_back(point);
    std::vector<std::uint32_t> to_new(tets_.keys.size());
    for (std::uint32_t v = 0; v < to_new.size(); ++v) {
      if (is_of_surface(tets_.keys[v])) {
        to_new[v] = local(static_cast<std::uint32_t>(tets_.keys[v]));
        continue;
      }
      to_new[v] = static_cast<std::uint32_t>(points.size());
      points.push_back(mesh_.points[v]);
      keys.push_back(tets_.keys[v]);
    }
    for (std::uint32_t& v : mesh_.to_vert) v = to_new[v];
    for (AcuteTet& tet : report_.acute_tets) {
      for (auto& triangle : tet.triangles)
        for (std::uint32_t& v : triangle) v = to_new[v];
      for (std::uint32_t& v : tet.points) v = to_new[v];
    }
    mesh_.points = std::move(points);
    tets_.keys = std::move(keys);
  }

  void freeze(std::span<const std::uint32_t> elsewhere) {
    is_frozen_.assign(points_.size(), 0);
    for (std::size_t i = 0; i < points_.size(); ++i) is_frozen_[i] = !is_own(surface_.points[i]);
    for (const std::uint32_t point : elsewhere)
      if (const auto at = std::lower_bound(points_.begin(), points_.end(), point); at != points_.end() && *at == point)
        is_frozen_[static_cast<std::size_t>(at - points_.begin())] = 1;
    for (const FaceCode face : mesh_.faces()) {
      if (mesh_.behind(face).valid() || mesh_.is_fixed(face)) continue;
      for (const std::uint32_t v : verts_of(mesh_, face))
        if (v < is_frozen_.size()) is_frozen_[v] = 1;
    }
  }

  // Whether the part may change what lies there. Where two parts do, each in or beside its own box, triangles at the
  // two places are apart, since the place of the part with the higher number is farther from the other box.
  bool is_own(const Vec3& x) const {
    const double size = input_.size_at(x), margin = kFromOtherBoxes * size;
    if (distance_outside(x, box_) > kBesideBox * size) return false;
    return std::ranges::none_of(input_.decomposition.neighbors(part_), [&](PartId other) {
      return other < part_ && is_within(x, input_.decomposition.box(other), margin);
    });
  }

  std::vector<ChangedTriangle> find_changes(const std::vector<TriangleVerts>& after) const {
    std::vector<ChangedTriangle> changed;
    for (std::size_t t = 0; t < after.size(); ++t) {
      if (after[t] == surface_.tri_to_vert[t]) continue;
      const auto& [a, b, c] = after[t];
      changed.push_back({triangles_[t], {points_[a], points_[b], points_[c]}});
    }
    return changed;
  }

  const SharedInput& input_;
  PartTets& tets_;
  TetMesh& mesh_;
  tets::OptimizeReport& report_;
  const Box3& box_;
  PartId part_;
  std::vector<std::uint32_t> triangles_, points_;  // of the complex, ascending
  volume::ComplexArrays arrays_;
  Complex surface_;  // of these
  std::vector<char> is_frozen_;
};

}  // namespace

bool wants_improvement(const SharedInput& input, double least_cubed) {
  return input.filling.freedom && least_cubed < tets::quality_to_improve(volume::optimize_options(input.filling));
}

std::vector<ChangedTriangle> improve_part(const SharedInput& input, PartTets& part_tets,
                                          std::span<const std::uint32_t> elsewhere, tets::OptimizeReport& report,
                                          PartId part, const TaskRunner& runner) {
  return Improvement(input, part_tets, report, part).run(elsewhere, runner);
}

std::vector<Placed<std::uint32_t>> find_border_points(const SharedInput& input, const KeyedTets& part_tets,
                                                      PartId part) {
  std::vector<char> seen(part_tets.keys.size(), 0);
  std::vector<std::uint32_t> used;
  const std::uint8_t* fixed = part_tets.mesh.to_fixed.data();
  const auto has_fixed = [fixed](std::size_t tet) { return fixed[tet] != 0; };
  tets::for_each_that(0, part_tets.mesh.size(), has_fixed, [&](std::size_t at) {
    const auto tet = static_cast<std::uint32_t>(at);
    if (part_tets.mesh.is_dead(tet)) return;
    for (const FaceCode face : FaceCode::of(tet)) {
      if (!part_tets.mesh.is_fixed(face)) continue;
      for (const std::uint32_t v : verts_of(part_tets.mesh, face))
        if (!std::exchange(seen[v], 1)) used.push_back(static_cast<std::uint32_t>(part_tets.keys[v]));
    }
  });
  sort_unique(used);
  std::vector<Placed<std::uint32_t>> border;
  for (const std::uint32_t point : used) {
    const Vec3& x = input.filling.complex.points[point];
    const double reach = Decomposition::kNeighborhood * input.size_at(x);
    if (depth_inside(x, input.decomposition.box(part)) <= reach) border.push_back({x, reach, point});
  }
  return border;
}

}  // namespace tetloom::parts

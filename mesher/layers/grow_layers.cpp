#include "mesher/layers/grow_layers.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/geometry/bad_geometry.hpp"
#include "mesher/intersection/self_intersection.hpp"
#include "mesher/layers/growth_paths.hpp"

namespace tetloom::layers {

namespace {

constexpr std::size_t kMostCrossings = 1'000'000;
constexpr int kMostHits = 6;  // of one curve: then it has no layers any more

// What is left of the layers of a curve that was in the way so often.
int count_after_hits(int count, int hits) {
  if (hits >= kMostHits) return 0;
  const double share = hits == 1 ? 0.9 : hits == 2 ? 0.7 : 0.5;
  return std::min(count - 1, static_cast<int>(share * count));
}

// The middle of its parameters; nothing where the geometry cannot be asked.
std::optional<Vec3> point_on(const GeometricModel& model, ModelFaceId face) {
  std::optional<Vec3> point;
  tolerate_bad_geometry([&] {
    const auto geometry = model.face_geometry(face);
    const ParameterBox box = geometry->parameter_box();
    const Vec2 middle{0.5 * (box.lo.u + box.hi.u), 0.5 * (box.lo.v + box.hi.v)};
    point = geometry->closest_point(geometry->evaluate(middle), std::nullopt).point;
  });
  return point;
}

[[noreturn]] void refuse(const GeometricModel& model, ModelFaceId face, const std::string& why) {
  Diagnostic diagnostic;
  diagnostic.code = ErrorCode::InvalidArgument;
  const bool is_known = face.value < model.topology().face_count();
  const NamedEntity named = is_known ? model.named(face) : NamedEntity{face, {}};
  diagnostic.message = "layers on " + describe(named) + ": " + why;
  diagnostic.entities = {named};
  if (is_known) diagnostic.point = point_on(model, face);
  throw Error(std::move(diagnostic));
}

}  // namespace

LayerGrowth::LayerGrowth(const GeometricModel& model, const Mesh& mesh, const SizeField& sizes,
                         const LayerOptions& options, const TaskRunner& runner)
    : model_(model),
      mesh_(mesh),
      sizes_(sizes),
      runner_(runner),
      walls_(find_walls(mesh, model.topology().face_to_sides, options)) {
  const auto& face_to_sides = model.topology().face_to_sides;
  sides_.emplace(mesh_, face_to_sides, walls_);
  side_meshes_.resize(sides_->side_count());
  const GrowthPaths paths = make_paths(mesh_, face_to_sides, walls_, *sides_, runner);
  counts_.emplace(mesh_, walls_, *sides_, paths, runner);
  make_surface();
}

LayerGrowth::~LayerGrowth() = default;

std::vector<CurveTop> LayerGrowth::tops() const {
  std::vector<CurveTop> tops(walls_.curve_count());
  for (std::uint32_t c = 0; c < tops.size(); ++c)
    tops[c] = {counts_->top(c), distance(counts_->point(c, 0), counts_->top(c)), counts_->count(c) > 0};
  return tops;
}

// Counts only fall, so this ends.
void LayerGrowth::make_surface() {
  std::vector<int> hits(walls_.curve_count(), 0);
  for (;;) {
    counts_->settle(runner_);
    std::vector<std::uint8_t> changed = counts_->take_changes();
    make_side_meshes(changed);
    std::vector<SideMesh> meshes;
    for (const auto& side : side_meshes_)
      if (side) meshes.push_back(*side);
    surface_ = make_layered_surface(mesh_, model_.topology().face_to_sides, walls_, *sides_, *counts_, meshes);
    if (!lower_at_crossings(changed, hits)) return;
  }
}

// Where the rest of a side face cannot be meshed, there are no layers on it. What changes by that is added to
// `changed`.
void LayerGrowth::make_side_meshes(std::vector<std::uint8_t>& changed) {
  for (bool again = true; again;) {
    again = false;
    const std::vector<CurveTop> all_tops = tops();
    std::vector<std::uint8_t> failed(sides_->side_count(), 0);
    runner_.for_each(sides_->side_count(), [&](std::size_t s) {
      const auto curves = sides_->curves_on(s);
      if (std::ranges::none_of(curves, [&](std::uint32_t c) { return changed[c] != 0; })) return;
      side_meshes_[s].reset();
      if (std::ranges::none_of(curves, [&](std::uint32_t c) { return all_tops[c].grows; })) return;
      side_meshes_[s] = sides_->mesh_rest(s, all_tops, sizes_, [&] { return !runner_.cancelled(); });
      failed[s] = side_meshes_[s]->mesh.verdict != FaceVerdict::Ok;
    });
    runner_.check_cancelled();
    for (std::size_t s = 0; s < failed.size(); ++s)
      if (failed[s])
        for (const std::uint32_t c : sides_->curves_on(s)) counts_->lower(c, 0, LayerLimit::SideAngle);
    again = std::ranges::count(failed, 1) > 0;
    if (again) {
      counts_->settle(runner_);
      const std::vector<std::uint8_t> more = counts_->take_changes();
      for (std::size_t c = 0; c < changed.size(); ++c) changed[c] |= more[c];
    }
  }
}

// Triangles of the surface that were not there, or elsewhere, when it was last looked at.
std::vector<std::uint8_t> LayerGrowth::new_triangles(const std::vector<std::uint8_t>& changed) const {
  std::vector<std::uint8_t> side_is_new(model_.topology().face_count(), 0);
  for (std::size_t s = 0; s < sides_->side_count(); ++s)
    side_is_new[sides_->face_of(s)] =
        std::ranges::any_of(sides_->curves_on(s), [&](std::uint32_t c) { return changed[c] != 0; });
  std::vector<std::uint8_t> is_new(surface_.is_top.size(), 0);
  for (std::size_t t = 0; t < is_new.size(); ++t) {
    if (const std::uint32_t wall = surface_.tri_to_wall[t]; wall != kNone)
      is_new[t] = std::ranges::any_of(walls_.triangles[wall].curves, [&](std::uint32_t c) { return changed[c] != 0; });
    else
      is_new[t] = side_is_new[surface_.mesh.tri_to_entity[t]];
  }
  return is_new;
}

// The exact test over walls, tops and all other surfaces of each region. False when nothing crosses.
bool LayerGrowth::lower_at_crossings(const std::vector<std::uint8_t>& changed, std::vector<int>& hits) {
  const std::vector<std::uint8_t> tri_is_new = new_triangles(changed);
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> groups, walls;
  std::vector<std::uint8_t> is_new;
  const auto add = [&](const std::array<std::uint32_t, 3>& verts, ModelRegionId region, std::uint32_t wall,
                       bool fresh) {
    if (!region.valid()) return;
    triangles.push_back(verts);
    groups.push_back(region.value);
    walls.push_back(wall);
    is_new.push_back(fresh);
  };
  for (std::size_t t = 0; t < surface_.is_top.size(); ++t) {
    const FaceSides& sides = surface_.tri_to_sides[t];
    const auto& verts = surface_.mesh.tri_to_vert[t];
    const std::uint32_t wall = surface_.tri_to_wall[t];
    add(verts, sides.front, wall, tri_is_new[t]);
    if (sides.back != sides.front) add(verts, sides.back, wall, tri_is_new[t]);
    // A wall triangle of which all corners have layers has none in common with its top.
    if (wall != kNone) add(walls_.triangles[wall].verts, sides.front, kNone, false);
  }
  const std::vector<TriangleIntersection> found =
      find_self_intersections({surface_.mesh.points, triangles, groups, kMostCrossings, false, is_new}, runner_);
  std::vector<std::uint8_t> is_hit(walls_.curve_count(), 0);
  for (const TriangleIntersection& hit : found)
    for (const std::uint32_t triangle : {hit.first, hit.second})
      if (walls[triangle] != kNone)
        for (const std::uint32_t c : walls_.triangles[walls[triangle]].curves) is_hit[c] = counts_->count(c) > 0;
  // A side face that crosses something has too much on it.
  for (const TriangleIntersection& hit : found)
    for (std::size_t s = 0; s < sides_->side_count(); ++s) {
      if (walls[hit.first] != kNone || walls[hit.second] != kNone) break;
      for (const std::uint32_t c : sides_->curves_on(s)) is_hit[c] = counts_->count(c) > 0;
    }
  bool any = false;
  for (std::uint32_t c = 0; c < is_hit.size(); ++c) {
    if (!is_hit[c]) continue;
    any = true;
    counts_->lower(c, count_after_hits(counts_->count(c), ++hits[c]), LayerLimit::Crossing);
  }
  return any;
}

bool LayerGrowth::lower(std::span<const std::uint32_t> regions, double share) {
  bool any = false;
  for (std::uint32_t c = 0; c < walls_.curve_count(); ++c) {
    const std::uint32_t region = walls_.triangles[walls_.triangles_at(c)[0]].region;
    if (counts_->count(c) == 0 || std::ranges::count(regions, region) == 0) continue;
    any = true;
    counts_->lower(c, static_cast<int>(share * counts_->count(c)), LayerLimit::Filling);
  }
  if (any) make_surface();
  return any;
}

void check_layer_options(const GeometricModel& model, const LayerOptions& options) {
  constexpr int kMostLayers = 1000;
  constexpr double kMostGrowth = 10;
  std::vector<std::uint8_t> is_wall(model.topology().face_count(), 0);
  for (const WallLayers& wall : options.walls) {
    if (wall.face.value >= is_wall.size()) refuse(model, wall.face, "the model has no such face");
    if (is_wall[wall.face.value]++) refuse(model, wall.face, "the face is named twice");
    if (!(wall.first_height > 0 && std::isfinite(wall.first_height)))
      refuse(model, wall.face, "the first height must be positive");
    if (wall.first_height > model.bounding_box().diagonal())
      refuse(model, wall.face, "the first layer would be higher than the model is large");
    if (!(wall.growth >= 1 && wall.growth <= kMostGrowth))
      refuse(model, wall.face, "the growth must lie between 1 and 10");
    if (wall.count < 0 || wall.count > kMostLayers) refuse(model, wall.face, "there can be 0 to 1000 layers");
    if (!(wall.thickness >= 0 && std::isfinite(wall.thickness)))
      refuse(model, wall.face, "the thickness must be positive (or 0 to leave it unset)");
    const FaceSides& sides = model.topology().face_to_sides[wall.face.value];
    if (!(wall.in_front && sides.front.valid()) && !(wall.behind && sides.back.valid()))
      refuse(model, wall.face, "the face bounds no region on the sides asked for");
  }
}

}  // namespace tetloom::layers

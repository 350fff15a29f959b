#include "mesher/layers/grow_layers.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/lists.hpp"
#include "core/geometry/bad_geometry.hpp"
#include "mesher/layers/crossings.hpp"
#include "mesher/layers/regrowth.hpp"
#include "mesher/layers/room_above.hpp"

namespace tetloom::layers {

namespace {

constexpr int kMostTries = 4;        // to grow layers, without fans where they failed
constexpr double kLeastAtFan = 0.2;  // of the width: thinner layers leave no room for good tets above fans
constexpr int kMostHits = 6;         // of one curve: then it has no layers any more

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
    : model_(model), mesh_(mesh), sizes_(sizes), options_(options), runner_(runner) {
  int tries = 0;
  for (std::vector<std::uint32_t> failed = grow(tries); !failed.empty(); failed = grow(++tries)) {
    blunt_verts_.insert(blunt_verts_.end(), failed.begin(), failed.end());
    sort_unique(blunt_verts_);
  }
  before_.reset();
}

// The vertices of fans that are none, where there are some; what is around them is made anew without them.
std::vector<std::uint32_t> LayerGrowth::grow(int tries) {
  const auto& face_to_sides = model_.topology().face_to_sides;
  walls_ = find_walls(mesh_, face_to_sides, options_, blunt_verts_);
  sides_.emplace(model_, mesh_, walls_, runner_);
  side_meshes_.clear();
  side_meshes_.resize(sides_->sides().size());
  const std::vector<std::uint32_t> kept =
      before_ ? find_kept_curves(walls_, before_->walls) : std::vector<std::uint32_t>{};
  GrowthPaths paths =
      make_paths({mesh_, face_to_sides, walls_, *sides_}, runner_, {before_ ? &before_->paths : nullptr, kept});
  if (!paths.fans_without_room.empty()) {
    std::vector<std::uint32_t> failed = paths.fans_without_room;
    if (!before_) before_ = {walls_, std::move(paths), {}, {}};
    return failed;
  }
  counts_.emplace(walls_, *sides_, paths, runner_, kept_counts(kept));
  surface_ = LayeredSurface();
  std::vector<std::uint32_t> failed = settle(tries, kept);
  if (failed.empty()) return failed;
  before_ = {walls_, std::move(paths), {}, {}};
  if (!surface_.curve_to_top.empty()) before_->tops = tops();
  for (std::uint32_t c = 0; c < walls_.curve_count(); ++c)
    before_->counts.push_back({counts_->count(c), counts_->limit(c)});
  return failed;
}

std::vector<KeptCount> LayerGrowth::kept_counts(std::span<const std::uint32_t> kept) const {
  if (!before_ || before_->counts.empty()) return {};
  std::vector<KeptCount> counts;
  for (const std::uint32_t old : kept) counts.push_back(old == kNone ? KeptCount{} : before_->counts[old]);
  return counts;
}

// Curves that are as high as before, when nothing crossed.
std::vector<std::uint8_t> LayerGrowth::is_proven(std::span<const std::uint32_t> kept) const {
  if (!before_ || before_->tops.empty()) return {};
  std::vector<std::uint8_t> proven(kept.size(), 0);
  for (std::uint32_t c = 0; c < kept.size(); ++c)
    proven[c] = kept[c] != kNone && before_->counts[kept[c]].count == counts_->count(c) &&
                before_->tops[kept[c]].point == counts_->top(c);
  return proven;
}

std::vector<std::uint32_t> LayerGrowth::settle(int tries, std::span<const std::uint32_t> kept) {
  counts_->settle(runner_);
  if (tries < kMostTries)
    if (std::vector<std::uint32_t> thin = thin_fans(); !thin.empty()) return thin;
  counts_->mend_shapes(runner_);
  make_surface(is_proven(kept));
  return tries < kMostTries ? thin_fans() : std::vector<std::uint32_t>{};
}

std::vector<std::uint32_t> LayerGrowth::thin_fans() const {
  std::vector<std::uint32_t> thin;
  for (const FanVertex& fan : walls_.fan_vertices)
    if (std::ranges::any_of(fan.curves, [&](std::uint32_t c) {
          return counts_->thickness(c) < kLeastAtFan * walls_.curve_to_width[c];
        }))
      thin.push_back(walls_.curve_to_vert[fan.curves[0]]);
  return thin;
}

LayerGrowth::~LayerGrowth() = default;

std::vector<CurveTop> LayerGrowth::tops() const {
  std::vector<CurveTop> tops(walls_.curve_count());
  for (std::uint32_t c = 0; c < tops.size(); ++c)
    tops[c] = {counts_->top(c), distance(counts_->point(c, 0), counts_->top(c)), counts_->count(c) > 0};
  return tops;
}

// Counts only fall, so this ends. Between curves that are proven nothing crosses as they are.
void LayerGrowth::make_surface(std::span<const std::uint8_t> is_proven) {
  std::vector<int> hits(walls_.curve_count(), 0);
  std::vector<std::uint8_t> unseen(walls_.curve_count(), 1);  // changed since it was asked whether room lacks
  for (;;) {
    counts_->settle(runner_);
    std::vector<std::uint8_t> changed = counts_->take_changes();
    for (std::size_t c = 0; c < is_proven.size(); ++c) changed[c] = changed[c] && !is_proven[c];
    is_proven = {};
    make_side_meshes(changed, hits);
    for (std::size_t c = 0; c < changed.size(); ++c) unseen[c] |= changed[c];
    std::vector<SideMesh> meshes;
    for (const auto& side : side_meshes_)
      if (side) meshes.push_back(*side);
    surface_ = make_layered_surface(mesh_, model_.topology().face_to_sides, walls_, *sides_, *counts_, meshes);
    if (!lower_at_crossings(changed, hits) && !lower_where_room_lacks(unseen)) return;
  }
}

// Where the rest of a side face cannot be meshed, there are fewer layers on it, and none in the end. What changes by
// that is added to `changed`.
void LayerGrowth::make_side_meshes(std::vector<std::uint8_t>& changed, std::vector<int>& hits) {
  std::vector<std::uint8_t> is_new = changed;
  for (bool again = true; again;) {
    const std::vector<CurveTop> all_tops = tops();
    const std::span<const SideFace> sides = sides_->sides();
    runner_.for_each(sides.size(), [&](std::size_t s) {
      const auto& curves = sides[s].curves;
      if (side_meshes_[s] && std::ranges::none_of(curves, [&](std::uint32_t c) { return is_new[c] != 0; })) return;
      side_meshes_[s].reset();
      if (std::ranges::none_of(curves, [&](std::uint32_t c) { return all_tops[c].grows; })) return;
      side_meshes_[s] = mesh_rest(*sides_, s, all_tops, sizes_, [&] { return !runner_.cancelled(); });
    });
    runner_.check_cancelled();
    std::vector<std::uint8_t> is_hit(walls_.curve_count(), 0);
    for (const auto& side : side_meshes_)
      if (side)
        for (const std::uint32_t c : side->in_the_way) is_hit[c] = 1;
    again = lower_hit(is_hit, hits, LayerLimit::SideAngle);
    if (!again) break;
    counts_->settle(runner_);
    is_new = counts_->take_changes();
    for (std::size_t c = 0; c < changed.size(); ++c) changed[c] |= is_new[c];
  }
}

bool LayerGrowth::lower_at_crossings(const std::vector<std::uint8_t>& changed, std::vector<int>& hits) {
  const std::vector<std::uint8_t> is_hit =
      find_curves_in_the_way({model_.topology().face_to_sides, walls_, *sides_, *counts_, surface_, changed}, runner_);
  return lower_hit(is_hit, hits, LayerLimit::Crossing);
}

// Of curves that are looked at for the first time since their count is what it is.
bool LayerGrowth::lower_where_room_lacks(std::vector<std::uint8_t>& unseen) {
  const std::vector<double> lacking = find_lacking_room(walls_, *counts_, surface_, unseen, runner_);
  std::ranges::fill(unseen, 0);
  for (std::uint32_t c = 0; c < lacking.size(); ++c)
    if (lacking[c] > 0) counts_->thin(c, lacking[c], LayerLimit::Gap);
  return std::ranges::any_of(lacking, [](double length) { return length > 0; });
}

// False where there is none.
bool LayerGrowth::lower_hit(const std::vector<std::uint8_t>& is_hit, std::vector<int>& hits, LayerLimit limit) {
  bool any = false;
  for (std::uint32_t c = 0; c < is_hit.size(); ++c) {
    if (!is_hit[c] || counts_->count(c) == 0) continue;
    any = true;
    counts_->lower(c, count_after_hits(counts_->count(c), ++hits[c]), limit);
  }
  return any;
}

bool LayerGrowth::lower(std::span<const std::uint32_t> regions, double share) {
  bool any = false;
  for (std::uint32_t c = 0; c < walls_.curve_count(); ++c) {
    if (counts_->count(c) == 0 || std::ranges::count(regions, walls_.curve_to_region[c]) == 0) continue;
    any = true;
    counts_->lower(c, static_cast<int>(share * counts_->count(c)), LayerLimit::Filling);
  }
  if (any) make_surface();
  return any;
}

void check_layer_options(const GeometricModel& model, const LayerOptions& options) {
  constexpr int kMostLayers = 1000;
  constexpr double kMostGrowth = 10;
  constexpr double kLeastFanAngle = 45, kMostFanAngle = 180;
  if (options.fan_angle != 0 && !(options.fan_angle >= kLeastFanAngle && options.fan_angle <= kMostFanAngle))
    throw Error(Diagnostic{ErrorCode::InvalidArgument,
                           "layers: the angle of fans must lie between 45 and 180 degrees, or be 0",
                           {},
                           {},
                           {}});
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

// What an adaptation starts with: the share of each rank, and the background.
#include <algorithm>
#include <array>

#include "adapt/adapter.hpp"
#include "adapt/parts/make_tiles.hpp"
#include "adapt/parts/model_fit.hpp"
#include "core/base/free_memory.hpp"

namespace tetloom::adapt {

namespace {

// Leaves what is referred to until the end: names, sides, and fields that are carried over with regions.
void drop_elements(Mesh& mesh, const std::vector<std::string>& transfer) {
  const auto is_needed = [&](const MeshField& field) { return std::ranges::count(transfer, field.name) != 0; };
  Mesh kept;
  kept.face_to_sides = std::move(mesh.face_to_sides), kept.entities = std::move(mesh.entities);
  for (MeshField& field : mesh.point_fields)
    if (is_needed(field)) kept.point_fields.push_back(std::move(field));
  for (MeshField& field : mesh.cell_fields)
    if (is_needed(field)) kept.cell_fields.push_back(std::move(field));
  if (!kept.cell_fields.empty()) kept.tet_to_entity = std::move(mesh.tet_to_entity);
  mesh = std::move(kept);
}

// Names and components stay.
void drop_values(std::vector<MeshField>& fields) {
  for (MeshField& field : fields) field.values = {};
}

}  // namespace

Adapter::Adapter(AdapterInput&& input, const MetricFunction& function, const AdaptOptions& options,
                 const SharedWork& work)
    : mesh_(input.mesh), function_(function), options_(options), work_(work), runner_(work.runner()) {
  if (function) input.metric = MetricField();
  // Fields on tets are carried over from a mesh in one piece.
  if (work_.rank_count() > 1 && !carries_on_tets(mesh_, options.transfer))
    keep_share(std::move(input));
  else
    keep_all(std::move(input));
}

void Adapter::keep_all(AdapterInput&& input) {
  make_whole();
  if (input.given_up) drop_elements(*input.given_up, options_.transfer);
  const std::size_t given = whole_.points.size();
  touching_ = separate_fans(whole_, runner_);
  WholeMesh rest;
  links_ = take_share(whole_, work_, &rest);
  keep_background(rest.size() > 0 ? rest : whole_, given, std::move(input.metric));
}

// What there is at vertices is known first, so that not all of it is there at once.
void Adapter::keep_share(AdapterInput&& input) {
  given_up_ = input.given_up;
  const auto rank = static_cast<std::size_t>(work_.rank());
  const std::vector<std::uint32_t> firsts =
      equal_ranges(mesh_.tet_to_vert.size(), static_cast<std::size_t>(work_.rank_count()));
  const TetSlice slice = slice_around(mesh_, firsts[rank], firsts[rank + 1] - firsts[rank]);
  FiguresBefore fields(mesh_, options_.transfer);
  given_verts_ = verts_of_mesh(mesh_, slice.is_own, input.metric, fields, runner_);
  fields_before_ = std::move(fields.figures);
  input.metric = MetricField();
  give_back_free_memory();
  try {
    whole_ = make_slice_mesh(mesh_, slice, runner_);
    if (options_.model) require_model_fits(whole_, mesh_, *options_.model, runner_);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::Cancelled) throw;
    make_whole();  // which says what is wrong as one process does
    needs_whole_ = true;
    return;
  }
  // Fans are named after each other, all over the mesh.
  needs_whole_ = has_fans_at(whole_, slice.is_own, runner_);
  if (!needs_whole_) links_ = take_share(whole_, slice, mesh_.tet_to_vert.size(), work_);
}

void Adapter::make_whole() {
  whole_ = make_whole_mesh(mesh_, runner_);
  if (options_.model) require_model_fits(whole_, mesh_, *options_.model, runner_);
}

void Adapter::spread() {
  if (background_) return;
  std::array<double, 1> needs_whole{needs_whole_ ? 1.0 : 0.0};
  work_.max(needs_whole);
  const std::size_t given = mesh_.points.size();
  work_.each([&] {
    if (needs_whole[0] > 0) {
      make_whole();
      touching_ = separate_fans(whole_, runner_);
      links_ = take_share(whole_, work_);
    }
    if (given_up_) drop_elements(*given_up_, options_.transfer), drop_values(given_up_->point_fields);
    share_verts_ = as_in_share(given_verts_, whole_, links_, touching_, given);
    given_verts_ = ShareVerts();
    give_back_free_memory();
  });
  tiles_ = make_tiles(whole_, links_, share_verts_, work_);
  share_verts_ = ShareVerts();
  background_.emplace(*tiles_);
}

// Tets may have been turned when they were linked, so they are those of `whole`, array by array.
void Adapter::keep_background(WholeMesh& whole, std::size_t given, MetricField&& metric) {
  const bool is_rest = &whole != &whole_;
  std::vector<TetVerts> tets = tets_before_fans(whole, touching_, given, runner_);
  if (is_rest) whole.to_vert.release();
  std::vector<std::uint32_t> links(whole.to_neighbor.begin(), whole.to_neighbor.end());
  if (is_rest) whole.to_neighbor.release();
  std::vector<Vec3> points(whole.points.begin(), whole.points.begin() + given);
  if (is_rest) whole = WholeMesh();
  background_.emplace(std::move(points), std::move(tets), std::move(links), std::move(metric), runner_);
  implied_ = implied_metric(background_->mesh(), runner_);
}

}  // namespace tetloom::adapt

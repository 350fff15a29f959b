// What an adaptation starts with: the share of each rank, and the background.
#include <algorithm>
#include <array>

#include "adapt/adapter.hpp"
#include "adapt/parts/make_tiles.hpp"
#include "adapt/parts/model_fit.hpp"
#include "adapt/parts/share_verts.hpp"
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

// Names and sides, and fields without values.
Mesh take_names(Mesh& mesh) {
  Mesh names;
  names.face_to_sides = std::move(mesh.face_to_sides), names.entities = std::move(mesh.entities);
  for (const MeshField& field : mesh.point_fields) names.point_fields.push_back({field.name, field.components, {}});
  for (const MeshField& field : mesh.cell_fields) names.cell_fields.push_back({field.name, field.components, {}});
  return names;
}

// The mesh that a slice has become has them too.
void drop_elements(MeshSlice& slice) {
  Mesh kept;
  kept.point_fields = std::move(slice.mesh.point_fields), kept.cell_fields = std::move(slice.mesh.cell_fields);
  slice.mesh = std::move(kept);
}

// Few vertices of the whole mesh may lie beside the model, however many a slice has.
void require_fit(const WholeMesh& mesh, const MeshSlice& slice, const GeometricModel& model, const SharedWork& work) {
  VerticesBesideModel beside = require_model_fits(mesh, slice.mesh, model, work.runner(), slice.to_vert_number);
  std::array<std::int64_t, 2> counts{beside.vertices, beside.count};
  work.sum(counts);
  beside.vertices = counts[0], beside.count = counts[1];
  require_few(beside);
}

// Of the mesh that a slice has become, while it has all tets around the slice's own.
ShareCells cells_of(const MeshSlice& slice, const WholeMesh& mesh, const TetView& tets, const AdaptOptions& options,
                    const TaskRunner& runner) {
  JoinedCells all = join_cells(slice.mesh, tets.tets.size(), options.transfer);
  ShareCells own{all.components, options.cell_reconstruction == CellReconstruction::Linear, {}, {}};
  if (all.components == 0) return own;
  if (own.has_slopes)
    own.slopes =
        limited_slopes({tets, mesh.to_neighbor.span(), mesh.to_region.span(), slice.begin, slice.end}, all, runner);
  const auto begin = all.values.begin();
  own.values.assign(begin + static_cast<std::ptrdiff_t>(slice.begin * all.components),
                    begin + static_cast<std::ptrdiff_t>(slice.end * all.components));
  return own;
}

}  // namespace

AdapterShare share_of(MeshSlice&& slice, const MetricFunction& function, const AdaptOptions& options,
                      const SharedWork& work) {
  AdapterShare share;
  share.mesh = make_slice_mesh(slice, work);
  if (options.model) require_fit(share.mesh, slice, *options.model, work);
  share.source = take_names(slice.mesh);
  drop_elements(slice);
  if (function) slice.metric = MetricField();
  SliceVerts verts;
  work.each([&] {
    verts.implied = implied_metric({share.mesh.points.span(), tets_of(share.mesh, work.runner())}, work.runner());
    verts.starts = first_tets_of(share.mesh.to_vert.span(), share.mesh.points.size());
  });
  ShareCells cells;
  if (!options.transfer.empty()) {
    const std::vector<TetVerts> tets = tets_of(share.mesh, work.runner());
    const TetView view{share.mesh.points.span(), tets};
    const FieldPlaces places{slice.mesh, {view, share.mesh.to_region.span()}, slice.begin, slice.end, slice.is_own};
    share.fields_before = fields_before(places, options.transfer, work);
    work.each([&] { cells = cells_of(slice, share.mesh, view, options, work.runner()); });
  }
  share.touching = separate_umbrellas(share.mesh, slice, work);
  std::vector<FaceOutside> faces;
  share.links = take_share(share.mesh, slice, faces);
  const ShareVerts own = verts_of_share(slice, verts, share.mesh, share.links, share.touching, options.transfer);
  slice = MeshSlice(), verts = SliceVerts();
  give_back_free_memory();
  const auto itself = [](std::uint32_t v) { return v; };
  share.first_stage = set_start_metric(share.mesh, {own.logs, own.implied, itself}, function, work);
  share.tiles = make_tiles(share.mesh, share.links, faces, own, cells, work);
  share.mesh.to_neighbor.release();
  return share;
}

Adapter::Adapter(AdapterShare&& share, const MetricFunction& function, const AdaptOptions& options,
                 const SharedWork& work)
    : source_(std::move(share.source)),
      mesh_(source_),
      function_(function),
      options_(options),
      work_(work),
      runner_(work.runner()),
      whole_(std::move(share.mesh)),
      touching_(std::move(share.touching)),
      links_(std::move(share.links)),
      fields_before_(std::move(share.fields_before)),
      tiles_(std::move(share.tiles)),
      background_(std::in_place, *tiles_),
      first_stage_(share.first_stage),
      ratio_(first_stage_.ratio) {}

Adapter::Adapter(AdapterInput&& input, const MetricFunction& function, const AdaptOptions& options,
                 const SharedWork& work)
    : mesh_(input.mesh), function_(function), options_(options), work_(work), runner_(work.runner()) {
  if (function) input.metric = MetricField();
  whole_ = make_whole_mesh(mesh_, runner_);
  if (options_.model) require_few(require_model_fits(whole_, mesh_, *options_.model, runner_));
  if (input.given_up) drop_elements(*input.given_up, options_.transfer);
  const std::size_t given = whole_.points.size();
  const std::vector<std::uint32_t> starts = first_tets_of(whole_.to_vert.span(), given);
  std::ranges::transform(starts, whole_.to_hint.begin(),
                         [](std::uint32_t tet) { return tet == kNone ? kNoTet : BackgroundTet{tet}; });
  touching_ = separate_umbrellas(whole_, runner_);
  keep_background(given, std::move(input.metric));
  const auto given_of = [&](std::uint32_t v) {
    if (whole_.to_hint[v] == kNoTet) return kNone;
    if (v < given) return v;
    return static_cast<std::uint32_t>(touching_.verts[whole_.to_entity[v].unpack().index - touching_.first]);
  };
  first_stage_ = set_start_metric(whole_, {background_->metric().logs, implied_, given_of}, function_, work_);
  ratio_ = first_stage_.ratio;
  links_ = take_share(whole_);
}

// Tets may have been turned when they were linked, so they are those of `whole`, array by array.
void Adapter::keep_background(std::size_t given, MetricField&& metric) {
  std::vector<TetVerts> tets = tets_before_umbrellas(whole_, touching_, given, runner_);
  std::vector<FaceCode> links(whole_.to_neighbor.begin(), whole_.to_neighbor.end());
  whole_.to_neighbor.release();
  std::vector<Vec3> points(whole_.points.begin(), whole_.points.begin() + given);
  background_.emplace(std::move(points), std::move(tets), std::move(links), std::move(metric), runner_);
  implied_ = implied_metric(background_->mesh(), runner_);
}

}  // namespace tetloom::adapt

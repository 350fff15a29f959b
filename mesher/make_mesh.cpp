#include <algorithm>
#include <new>

#include "core/base/stopwatch.hpp"
#include "mesher/complexes.hpp"
#include "mesher/intersection/self_intersection.hpp"
#include "mesher/mesher.hpp"
#include "mesher/sizing/build_size_field.hpp"
#include "mesher/surface/surface_mesher.hpp"
#include "mesher/volume/volume_mesher.hpp"

namespace tetloom {
namespace {

class MeshRun {
 public:
  MeshRun(const GeometricModel& model, const MeshOptions& options, const Host& host)
      : model_(model), options_(options), runner_(options.threads, host) {}

  MeshResult run() {
    for (std::size_t r = 0; r < model_.topology().region_count(); ++r)
      result_.model_volume += model_.volume(ModelRegionId(r));
    try {
      run_stages();
    } catch (const Error& error) {
      if (error.code() == ErrorCode::InvalidArgument) throw;
      fail(error.diagnostic());
    } catch (const std::bad_alloc&) {
      fail({ErrorCode::OutOfMemory, "the memory is exhausted", {}, {}, {}});
    }
    return std::move(result_);
  }

 private:
  void fail(const Diagnostic& diagnostic) {
    result_.status = diagnostic.code == ErrorCode::Cancelled ? MeshStatus::Cancelled : MeshStatus::Failed;
    result_.errors.push_back(diagnostic);
  }

  void run_stages() {
    if (!mesh_surface_without_crossings()) return;
    const bool has_regions = model_.topology().region_count() > 0;
    if (!options_.surface_only && has_regions && !mesh_volume()) return;
    result_.status = MeshStatus::Ok;
  }

  // Where the surface mesh crosses itself because its triangles are too coarse for the shape, the size is halved there
  // and the surface made anew; what still crosses after a few rounds crosses in the model.
  bool mesh_surface_without_crossings() {
    const std::vector<std::uint32_t> complexes = find_complexes(model_.topology());
    std::vector<PointSize> refinements;
    constexpr int kMostRounds = 6;
    for (int round = 0;; ++round) {
      Stopwatch watch;
      make_sizes(refinements);
      result_.seconds.size_field += watch.lap();
      SurfaceMeshResult surface = mesh_surface(model_, result_.sizes, runner_);
      const std::vector<TriangleIntersection> hits = find_intersections(surface.mesh, complexes);
      result_.seconds.surface += watch.lap();
      if (!surface.errors.empty()) return reject(std::move(surface));
      if (hits.empty()) return accept(std::move(surface));
      if (round == kMostRounds) return judge_crossings(std::move(surface), hits);
      for (const TriangleIntersection& hit : hits) refine_at(hit, surface.mesh, refinements);
    }
  }

  // The first field also says whether the mesh will fit in memory.
  void make_sizes(const std::vector<PointSize>& refinements) {
    if (!refinements.empty()) {
      result_.sizes = build_size_field(model_, options_.sizes, refinements, runner_, options_.max_memory);
      return;
    }
    const SizedModel sized = build_and_estimate(model_, options_.sizes, refinements, runner_, options_.max_memory);
    check_memory(options_.surface_only ? surface_part(sized.estimate) : sized.estimate, options_.max_memory);
    result_.sizes = sized.sizes;
  }

  std::vector<TriangleIntersection> find_intersections(const Mesh& mesh, const std::vector<std::uint32_t>& complexes) {
    std::vector<std::uint32_t> groups(mesh.tri_to_vert.size());
    for (std::size_t t = 0; t < groups.size(); ++t) groups[t] = complexes[mesh.tri_to_entity[t]];
    return find_self_intersections({mesh.points, mesh.tri_to_vert, groups}, runner_);
  }

  static double longest_edge(const Mesh& mesh, std::uint32_t tri) {
    const auto& [a, b, c] = mesh.tri_to_vert[tri];
    return std::max({distance(mesh.points[a], mesh.points[b]), distance(mesh.points[b], mesh.points[c]),
                     distance(mesh.points[c], mesh.points[a])});
  }

  static void refine_at(const TriangleIntersection& hit, const Mesh& mesh, std::vector<PointSize>& refinements) {
    const double length = std::max(longest_edge(mesh, hit.first), longest_edge(mesh, hit.second));
    refinements.push_back({hit.point, 0.5 * length});
  }

  bool reject(SurfaceMeshResult&& surface) {
    append(surface.errors, surface.warnings);
    result_.mesh = std::move(surface.mesh);
    result_.status = MeshStatus::Failed;
    return false;
  }

  bool accept(SurfaceMeshResult&& surface) {
    append({}, surface.warnings);
    result_.mesh = std::move(surface.mesh);
    return true;
  }

  // Crossings spoil a solid; sheets may cross.
  bool judge_crossings(SurfaceMeshResult&& surface, const std::vector<TriangleIntersection>& hits) {
    const std::vector<Diagnostic> found = describe_intersections(hits, {surface.mesh.tri_to_entity, &model_});
    const auto bounds_region = [&](const NamedEntity& entity) {
      const FaceSides& sides = model_.topology().face_to_sides[entity.entity.index];
      return entity.entity.dim == 2 && (sides.front.valid() || sides.back.valid());
    };
    std::vector<Diagnostic> errors, warnings = surface.warnings;
    for (const Diagnostic& diagnostic : found) {
      const bool fatal = std::any_of(diagnostic.entities.begin(), diagnostic.entities.end(), bounds_region);
      (fatal && !options_.surface_only ? errors : warnings).push_back(diagnostic);
    }
    append(errors, warnings);
    result_.mesh = std::move(surface.mesh);
    if (!errors.empty()) result_.status = MeshStatus::Failed;
    return errors.empty();
  }

  void append(const std::vector<Diagnostic>& errors, const std::vector<Diagnostic>& warnings) {
    result_.errors.insert(result_.errors.end(), errors.begin(), errors.end());
    result_.warnings.insert(result_.warnings.end(), warnings.begin(), warnings.end());
  }

  bool mesh_volume() {
    Stopwatch watch;
    Mesh& mesh = result_.mesh;
    std::vector<FaceSides> sides(mesh.tri_to_vert.size());
    for (std::size_t t = 0; t < sides.size(); ++t) sides[t] = model_.topology().face_to_sides[mesh.tri_to_entity[t]];
    const VolumeInput input{mesh.points,          mesh.tri_to_vert, sides, mesh.tri_to_entity, &model_, &result_.sizes,
                            mesh.point_to_entity, mesh.edge_to_vert};
    const VolumeOptions options{options_.volume_worker, options_.worker_only, options_.improve_surface,
                                options_.max_memory};
    VolumeMesh volume = fill_volume(input, options, runner_);
    result_.seconds.volume += watch.lap();
    result_.filling = volume.figures;
    append(volume.errors, volume.warnings);
    if (!volume.errors.empty()) {
      result_.status = MeshStatus::Failed;
      return false;
    }
    add_volume(std::move(volume));
    return true;
  }

  void add_volume(VolumeMesh&& volume) {
    Mesh& mesh = result_.mesh;
    const std::size_t given = mesh.points.size();
    for (const MovedPoint& moved : volume.moved_points) mesh.points[moved.point] = moved.to;
    for (const ChangedTriangle& changed : volume.changed_triangles) mesh.tri_to_vert[changed.triangle] = changed.verts;
    mesh.points.insert(mesh.points.end(), volume.new_points.begin(), volume.new_points.end());
    mesh.point_to_entity.resize(mesh.points.size());
    mesh.tet_to_vert = std::move(volume.tet_to_vert);
    mesh.tet_to_entity = std::move(volume.tet_to_region);
    for (std::size_t t = 0; t < mesh.tet_to_vert.size(); ++t)
      for (const std::uint32_t v : mesh.tet_to_vert[t])
        if (v >= given) mesh.point_to_entity[v] = ModelRegionId(mesh.tet_to_entity[t]);
  }

  const GeometricModel& model_;
  const MeshOptions& options_;
  TaskRunner runner_;
  MeshResult result_;
};

}  // namespace

MeshResult make_mesh(const GeometricModel& model, const MeshOptions& options, const Host& host) {
  if (options.parts < 0) throw Error(ErrorCode::InvalidArgument, "the number of parts must not be negative");
  return MeshRun(model, options, host).run();
}

}  // namespace tetloom

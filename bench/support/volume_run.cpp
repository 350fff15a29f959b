#include "bench/support/volume_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <stdexcept>

#include "bench/support/child_process.hpp"
#include "bench/support/machine.hpp"
#include "mesher/sizing/build_size_field.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::bench {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

SizeOptions size_options(const VolumeTask& task) {
  const WaveSize wave = task.wave();
  SizeOptions options;
  options.size = wave.largest();
  if (wave.is_uniform()) return options;
  options.gradation = wave.gradient;
  options.callback = [wave](const Vec3& x) { return wave.at(x); };
  return options;
}

double largest_cosine(const std::array<Vec3, 4>& x) {
  const Vec3 &a = x[0], &b = x[1], &c = x[2], &d = x[3];
  std::array<Vec3, 4> normals{cross(c - b, d - b), cross(d - a, c - a), cross(b - a, d - a), cross(c - a, b - a)};
  for (Vec3& normal : normals) normal = normalized(normal);
  double cosine = -1;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) cosine = std::max(cosine, -dot(normals[i], normals[j]));
  return cosine;
}

/// What compute_quality does not say: tets by their smallest angle, and how many a cube of the size holds.
void judge_tets(const Mesh& mesh, const SizeField& sizes, VolumeSample& sample) {
  const double cos_15 = std::cos(15 / kDegrees), cos_20 = std::cos(20 / kDegrees);
  double cubes = 0;
  std::uint64_t below_20 = 0;
  for (const auto& tet : mesh.tet_to_vert) {
    std::array<Vec3, 4> x;
    for (std::size_t i = 0; i < 4; ++i) x[i] = mesh.points[tet[i]];
    const double cosine = largest_cosine(x);
    sample.below_15 += cosine > cos_15;
    below_20 += cosine > cos_20;
    const double size = sizes.size_at(0.25 * (x[0] + x[1] + x[2] + x[3]));
    cubes += dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]) / 6 / (size * size * size);
  }
  const auto count = static_cast<double>(mesh.tet_to_vert.size());
  sample.below_20 = static_cast<double>(below_20) / count;
  sample.density = count / cubes;
}

void orient(Mesh& mesh) {
  double volume = 0;
  for (const auto& [a, b, c, d] : mesh.tet_to_vert) {
    const Vec3& o = mesh.points[a];
    volume += dot(cross(mesh.points[b] - o, mesh.points[c] - o), mesh.points[d] - o);
  }
  if (volume >= 0) return;
  for (auto& tet : mesh.tet_to_vert) std::swap(tet[2], tet[3]);
}

/// The surface as TetGen reads it, with the size at each point.
void write_surface(const Mesh& mesh, const WaveSize& wave, const std::filesystem::path& path) {
  std::ofstream file(path), sizes(std::filesystem::path(path).replace_extension(".mtr"));
  file.precision(17), sizes.precision(17);
  file << mesh.points.size() << " 3 0 0\n";
  sizes << mesh.points.size() << " 1\n";
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3& x = mesh.points[i];
    file << i << ' ' << x.x << ' ' << x.y << ' ' << x.z << '\n';
    sizes << wave.at(x) << '\n';
  }
  file << mesh.tri_to_vert.size() << " 0\n";
  for (const auto& [a, b, c] : mesh.tri_to_vert) file << "3 " << a << ' ' << b << ' ' << c << '\n';
  file << "0\n0\n";
  if (!file.flush() || !sizes.flush()) throw std::runtime_error("cannot write '" + path.string() + "'");
}

void note_filling(const FillingFigures& figures, VolumeSample& sample) {
  const FillingFigures::Seconds& s = figures.seconds;
  sample.filling = {s.points, s.core, s.delaunay, s.recovery, s.join, s.optimize};
  sample.forced = figures.optimizer.forced;
  sample.core_tets = figures.core_tets;
  sample.missing_triangles = figures.missing_triangles;
  sample.recovery_points = figures.recovery_points;
  sample.worker_complexes = figures.worker_complexes;
}

}  // namespace

void to_json(nlohmann::json& json, const VolumeTask& task) {
  json = {{"model", task.model.string()}, {"size", task.size},       {"gradient", task.gradient},
          {"start", task.start},          {"threads", task.threads}, {"surface_path", task.surface_path}};
}

void from_json(const nlohmann::json& json, VolumeTask& task) {
  task.model = json.at("model").get<std::string>();
  json.at("size").get_to(task.size), json.at("gradient").get_to(task.gradient);
  json.at("start").get_to(task.start), json.at("threads").get_to(task.threads);
  json.at("surface_path").get_to(task.surface_path);
}

SizeField make_sizes(const VolumeTask& task) {
  if (task.wave().is_uniform()) return SizeField::uniform(task.size);
  const ModelDocument document = read_model(task.model);
  return build_size_field(*document.model, size_options(task), {}, TaskRunner(0));
}

void judge_volume(Mesh& mesh, const SizeField& sizes, VolumeSample& sample) {
  orient(mesh);
  const TetQuality quality = compute_quality(mesh, &sizes).tets;
  if (quality.count == 0) throw std::runtime_error("a mesh without tets");
  sample.tets = quality.count, sample.points = mesh.points.size();
  sample.ratio_mean = quality.mean_ratio_mean;
  sample.ratio_p1 = quality.mean_ratio_p1;
  sample.ratio_min = quality.mean_ratio_min;
  sample.min_dihedral_deg = quality.min_dihedral_deg;
  sample.edge_ratio = quality.edges.mean_length_ratio;
  sample.in_band = quality.edges.in_band;
  judge_tets(mesh, sizes, sample);
}

VolumeSample measure_volume_here(const VolumeTask& task) {
  const ModelDocument document = read_model(task.model);
  MeshOptions options;
  options.sizes = size_options(task);
  options.threads = task.threads;
  options.surface_only = !task.surface_path.empty();
  MeshResult result = make_mesh(*document.model, options);
  VolumeSample sample;
  sample.peak_bytes = peak_resident_bytes();
  if (result.status != MeshStatus::Ok) throw Error(result.errors.at(0));
  sample.seconds = result.seconds.volume;
  sample.size_seconds = result.seconds.size_field;
  sample.surface_seconds = result.seconds.surface;
  if (options.surface_only) {
    write_surface(result.mesh, task.wave(), task.surface_path);
    return sample;
  }
  note_filling(result.filling, sample);
  judge_volume(result.mesh, result.sizes, sample);
  sample.digest = mesh_digest(result.mesh);
  return sample;
}

VolumeSample measure_volume_apart(const std::string& program, const VolumeTask& task) {
  const ChildResult child = run_child({program, "--measure", nlohmann::json(task).dump()});
  if (child.exit_status != 0) throw std::runtime_error("meshing '" + task.model.string() + "' failed: " + child.output);
  return nlohmann::json::parse(child.output).get<VolumeSample>();
}

double find_volume_size(const std::string& program, VolumeTask task, double tets) {
  const ModelDocument document = read_model(task.model);
  double volume = 0;
  for (std::size_t r = 0; r < document.model->topology().region_count(); ++r)
    volume += document.model->volume(ModelRegionId(r));
  // A wave holds about a fourteenth of what its smallest size alone would; how much depends on the model.
  task.size = std::cbrt(kTetsPerCube * volume / tets / (task.gradient > 0 ? 14 : 1));
  for (int round = 0; round < 2 && task.gradient > 0; ++round)
    task.size *= std::cbrt(static_cast<double>(measure_volume_apart(program, task).tets) / tets);
  const double digit = std::pow(10, std::floor(std::log10(task.size)) - 2);
  return digit * std::round(task.size / digit);
}

double find_wave_start(const std::filesystem::path& model) {
  const Box3 box = read_model(model).model->bounding_box();
  const Vec3 width = box.hi - box.lo;
  return dot(box.center(), WaveSize::kDirection) - 0.5 * std::max({width.x, width.y, width.z});
}

}  // namespace tetloom::bench

#include "mesher/volume/volume_mesher.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <optional>
#include <utility>

#include "mesher/sizing/mesh_estimate.hpp"
#include "mesher/volume/complex.hpp"
#include "mesher/volume/fill_complex.hpp"
#include "mesher/volume/volume_parts.hpp"
#include "mesher/volume/volume_parts_detail.hpp"
#include "mesher/volume/worker_process.hpp"

namespace tetloom {

namespace {

using volume::Complex;
using volume::FilledComplex;

constexpr std::size_t kTetsPerTask = 1 << 16;

[[noreturn]] void refuse(const std::string& why) { throw Error(ErrorCode::InvalidArgument, "volume input: " + why); }

// Between these, sixth powers of lengths are numbers: qualities are made of them.
constexpr double kLargestCoordinate = 1e45, kLeastExtent = 1e-40;

bool is_sound(const Vec3& p) {
  return std::abs(p.x) <= kLargestCoordinate && std::abs(p.y) <= kLargestCoordinate &&
         std::abs(p.z) <= kLargestCoordinate;
}

// The point is another corner of the triangle, where there is a sound one.
[[noreturn]] void refuse_coordinate(const VolumeInput& input, std::uint32_t triangle) {
  Diagnostic diagnostic;
  diagnostic.code = ErrorCode::InvalidArgument;
  diagnostic.elements = {triangle};
  diagnostic.entities = volume::faces_of(input, std::span(&triangle, 1));
  diagnostic.message = "volume input: a coordinate of a triangle on " + describe(diagnostic.entities[0]) +
                       " is not finite or beyond 1e45";
  for (const std::uint32_t vertex : input.tri_to_vert[triangle]) {
    if (is_sound(input.points[vertex])) diagnostic.point = input.points[vertex];
  }
  throw Error(std::move(diagnostic));
}

void check_input(const VolumeInput& input) {
  if (!input.sizes) refuse("there is no size field");
  const std::size_t count = input.tri_to_vert.size();
  if (input.tri_to_sides.size() != count || input.tri_to_face.size() != count) refuse("its arrays differ in length");
  if (input.points.size() >= std::numeric_limits<std::uint32_t>::max()) refuse("there are too many points");
  if (!input.point_to_entity.empty() && input.point_to_entity.size() != input.points.size())
    refuse("its arrays differ in length");
  for (const auto& edge : input.edge_to_vert) {
    if (std::max(edge[0], edge[1]) >= input.points.size()) refuse("an edge refers to a point that does not exist");
  }
  for (const auto& triangle : input.tri_to_vert) {
    for (const std::uint32_t vertex : triangle) {
      if (vertex >= input.points.size()) refuse("a triangle refers to a point that does not exist");
    }
  }
  Box3 box;
  for (std::uint32_t t = 0; t < count; ++t) {
    for (const std::uint32_t vertex : input.tri_to_vert[t]) {
      if (!is_sound(input.points[vertex])) refuse_coordinate(input, t);
      box.add(input.points[vertex]);
    }
  }
  if (!box.empty() && box.lo != box.hi && box.diagonal() < kLeastExtent) refuse("its surface is smaller than 1e-40");
}

Diagnostic worker_missing(const VolumeInput& input, const Complex& complex, const Error& error) {
  Diagnostic diagnostic = error.diagnostic();
  diagnostic.message = volume::describe_regions(input, complex.regions) + " cannot be filled: " + diagnostic.message;
  diagnostic.entities = volume::faces_of(input, complex.to_input_tri);
  for (const std::uint32_t region : complex.regions) {
    diagnostic.entities.push_back(volume::named_entity(input, {3, region}));
  }
  diagnostic.point = complex.points[0];
  return diagnostic;
}

// What has become of the complex's surface.
void append_changes(const Complex& complex, const FilledComplex& filled, VolumeMesh& mesh) {
  for (std::size_t v = 0; v < complex.points.size(); ++v) {
    const Vec3& now = filled.filling->points[v];
    if (now != complex.points[v]) mesh.moved_points.push_back({complex.to_input_vert[v], now});
  }
  for (std::size_t t = 0; t < filled.tri_to_vert.size(); ++t) {
    const auto& [a, b, c] = filled.tri_to_vert[t];
    if (filled.tri_to_vert[t] == complex.tri_to_vert[t]) continue;
    const auto& to_input = complex.to_input_vert;
    mesh.changed_triangles.push_back({complex.to_input_tri[t], {to_input[a], to_input[b], to_input[c]}});
  }
}

void append(const VolumeInput& input, const Complex& complex, volume::Filling&& filling, VolumeMesh& mesh,
            const TaskRunner& runner) {
  const std::size_t given = complex.points.size(), offset = input.points.size() + mesh.new_points.size();
  if (offset + filling.points.size() >= std::numeric_limits<std::uint32_t>::max()) throw std::bad_alloc();
  mesh.new_points.insert(mesh.new_points.end(), filling.points.begin() + static_cast<std::ptrdiff_t>(given),
                         filling.points.end());
  const std::size_t first = mesh.tet_to_vert.size();
  if (first == 0 && offset == given) {  // all numbers are the input's
    mesh.tet_to_vert = std::move(filling.tet_to_vert);
    mesh.tet_to_region = std::move(filling.tet_to_region);
    return;
  }
  mesh.tet_to_vert.resize(first + filling.tet_to_vert.size());
  runner.for_blocks(filling.tet_to_vert.size(), kTetsPerTask, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tet = begin; tet < end; ++tet) {
      for (std::size_t i = 0; i < 4; ++i) {
        const std::uint32_t v = filling.tet_to_vert[tet][i];
        mesh.tet_to_vert[first + tet][i] =
            v < given ? complex.to_input_vert[v] : static_cast<std::uint32_t>(v - given + offset);
      }
    }
  });
  mesh.tet_to_region.insert(mesh.tet_to_region.end(), filling.tet_to_region.begin(), filling.tet_to_region.end());
}

// Fills all complexes, and gives them one after the other to `take`.
template <class Result, class Take>
void fill_complexes(const VolumeInput& input, const VolumeOptions& options, const TaskRunner& runner, Result& result,
                    bool keep_parts, const Take& take) {
  volume::OpenRegions open = volume::find_open_regions(input);
  result.errors = std::move(open.diagnostics);
  const std::vector<Complex> complexes = volume::split_complexes(input, open.regions);
  std::vector<double> work;
  std::vector<volume::FillingProgress> progress;
  std::uint64_t whole = 0;
  for (const Complex& complex : complexes) {
    whole += progress.emplace_back(input, complex).whole();
    work.push_back(static_cast<double>(progress.back().whole()));
  }
  runner.begin_stage(Stage::Volume, whole);
  if (complexes.empty()) return;
  volume::ComplexOptions how{{}, options.worker_only, nullptr, options.goals, options.lattice};
  if (options.tets_per_part > 0) how.tets_per_part = options.tets_per_part;
  how.trace = options.trace;
  how.keep_parts = keep_parts;
  try {
    how.worker = volume::find_worker(options.worker);
  } catch (const Error& error) {
    if (options.worker_only || !options.worker.empty()) {
      for (const Complex& complex : complexes) result.errors.push_back(worker_missing(input, complex, error));
      return;
    }
  }
  std::optional<volume::SurfaceFreedom> freedom;
  if (options.improve_surface) how.freedom = &freedom.emplace(input, complexes);
  std::vector<FilledComplex> filled(complexes.size());
  runner.for_each_largest_first(work, [&](std::size_t i) {
    filled[i] = volume::fill_complex(input, complexes[i], how, progress[i], runner);
    progress[i].reach(volume::FillingStep::Done, runner);
  });
  for (std::size_t i = 0; i < complexes.size(); ++i) {
    take(complexes[i], filled[i]);
    for (auto* to : {&result.errors, &result.warnings}) {
      auto& from = to == &result.errors ? filled[i].errors : filled[i].warnings;
      std::move(from.begin(), from.end(), std::back_inserter(*to));
    }
    result.figures.add(filled[i].figures);
    filled[i] = {};
  }
}

// What every way of filling begins with, and what becomes of a lack of memory.
template <class Fill>
void fill_checked(const VolumeInput& input, const VolumeOptions& options, const Fill& fill) {
  check_input(input);
  check_goals(options.goals);
  if (!(options.tets_per_part >= 0)) refuse("the number of tets per part must not be negative");
  check_memory(estimate_filling(input), options.max_memory);
  try {
    fill();
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::OutOfMemory, "not enough memory to fill the volume");
  }
}

}  // namespace

void FillingPartsFigures::add(const FillingPartsFigures& other) {
  parts += other.parts, asked += other.asked;
  asking_rounds = std::max(asking_rounds, other.asking_rounds);
  for (std::size_t round = 0; round < strips.size(); ++round) {
    for (const auto member : {&Strips::waiting, &Strips::tets, &Strips::moved})
      strips[round].*member += other.strips[round].*member;
  }
  if (given_up == 0) given_up_why = other.given_up_why;
  given_up += other.given_up;
}

void FillingFigures::add(const FillingFigures& other) {
  core_tets += other.core_tets;
  shell_tets += other.shell_tets;
  worker_complexes += other.worker_complexes;
  missing_triangles += other.missing_triangles;
  recovery_points += other.recovery_points;
  parts.add(other.parts);
  optimizer.add(other.optimizer);
  for (const auto member : {&Seconds::points, &Seconds::core, &Seconds::delaunay, &Seconds::recovery, &Seconds::join,
                            &Seconds::optimize, &Seconds::surface})
    seconds.*member += other.seconds.*member;
}

VolumeMesh fill_volume(const VolumeInput& input, const VolumeOptions& options, const TaskRunner& runner) {
  VolumeMesh mesh;
  fill_checked(input, options, [&] {
    fill_complexes(input, options, runner, mesh, false, [&](const Complex& complex, FilledComplex& filled) {
      if (!filled.filling) return;
      append_changes(complex, filled, mesh);
      append(input, complex, std::move(*filled.filling), mesh, runner);
    });
  });
  std::ranges::sort(mesh.moved_points, {}, &MovedPoint::point);
  std::ranges::sort(mesh.changed_triangles, {}, &ChangedTriangle::triangle);
  return mesh;
}

VolumeParts fill_volume_in_parts(const VolumeInput& input, const VolumeOptions& options, const TaskRunner& runner) {
  VolumeParts result;
  std::uint64_t next_point = input.points.size();
  fill_checked(input, options, [&] {
    fill_complexes(input, options, runner, result, true, [&](const Complex& complex, FilledComplex& filled) {
      volume::keep_as_parts(complex, filled);
      volume::to_numbers_of_input(complex, next_point, filled.parts, runner);
      next_point += filled.new_points;
      std::move(filled.parts.begin(), filled.parts.end(), std::back_inserter(result.parts));
    });
  });
  return result;
}

}  // namespace tetloom

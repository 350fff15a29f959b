#include "mesher/volume/volume_mesher.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/first_number.hpp"
#include "mesher/sizing/mesh_estimate.hpp"
#include "mesher/tets/quality_goals.hpp"
#include "mesher/volume/complex.hpp"
#include "mesher/volume/fill_complex.hpp"
#include "mesher/volume/fill_on_ranks.hpp"
#include "mesher/volume/worker_process.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

namespace {

using volume::Complex;

constexpr std::size_t kTrianglesPerTask = 1 << 12;

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

// `count` where all are good.
template <class IsGood>
std::size_t find_first_bad(std::size_t count, const SharedWork& work, const IsGood& is_good) {
  std::vector<std::size_t> block_to_bad((count + kTrianglesPerTask - 1) / kTrianglesPerTask, count);
  work.fill<std::size_t>(block_to_bad, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t block = first; block < last; ++block) {
      std::size_t t = block * kTrianglesPerTask;
      const std::size_t end = std::min(count, t + kTrianglesPerTask);
      while (t < end && is_good(t)) ++t;
      if (t < end) block_to_bad[block] = t;
    }
  });
  return block_to_bad.empty() ? count : std::ranges::min(block_to_bad);
}

void check_input(const VolumeInput& input, const SharedWork& work) {
  if (!input.sizes) refuse("there is no size field");
  const std::size_t count = input.tri_to_vert.size();
  if (input.tri_to_sides.size() != count || input.tri_to_face.size() != count) refuse("its arrays differ in length");
  if (input.points.size() >= std::numeric_limits<std::uint32_t>::max()) refuse("there are too many points");
  if (!input.point_to_entity.empty() && input.point_to_entity.size() != input.points.size())
    refuse("its arrays differ in length");
  for (const auto& edge : input.edge_to_vert) {
    if (std::max(edge[0], edge[1]) >= input.points.size()) refuse("an edge refers to a point that does not exist");
  }
  const auto exist = [&](std::size_t t) {
    const auto& verts = input.tri_to_vert[t];
    return std::ranges::all_of(verts, [&](std::uint32_t vertex) { return vertex < input.points.size(); });
  };
  if (find_first_bad(count, work, exist) < count) refuse("a triangle refers to a point that does not exist");
  const auto are_sound = [&](std::size_t t) {
    const auto& verts = input.tri_to_vert[t];
    return std::ranges::all_of(verts, [&](std::uint32_t vertex) { return is_sound(input.points[vertex]); });
  };
  if (const std::size_t bad = find_first_bad(count, work, are_sound); bad < count)
    refuse_coordinate(input, static_cast<std::uint32_t>(bad));
  // One point far from the first is enough; else all are looked at.
  Box3 box;
  for (std::uint32_t t = 0; t < count && box.diagonal() < kLeastExtent; ++t)
    for (const std::uint32_t vertex : input.tri_to_vert[t]) box.add(input.points[vertex]);
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

// What is to be filled.
struct Filling {
  volume::Complexes complexes;
  std::vector<volume::FillingProgress> progress;
  std::optional<volume::SurfaceFreedom> freedom;
};

void plan_filling(volume::FillingPlan& plan, const SharedWork& work, Filling& filling, VolumeParts& result) {
  const VolumeInput& input = plan.input;
  const VolumeOptions& options = plan.options;
  const TaskRunner& runner = work.runner();
  std::optional<TraceSpan> span(std::in_place, options.trace, "shells", runner.threads(),
                                volume::open_region_pieces(input));
  volume::OpenRegions open = volume::find_open_regions(input, work);
  span.emplace(options.trace, "plan");
  result.errors = std::move(open.diagnostics);
  filling.complexes = volume::split_complexes(input, open.regions);
  std::uint64_t whole = 0;
  for (const Complex& complex : filling.complexes.list) whole += filling.progress.emplace_back(input, complex).whole();
  runner.begin_stage(Stage::Volume, whole);
  if (filling.complexes.list.empty()) return;
  try {
    plan.worker = volume::find_worker(options.worker);
  } catch (const Error& error) {
    if (options.worker_only || !options.worker.empty()) {
      for (const Complex& complex : filling.complexes.list)
        result.errors.push_back(worker_missing(input, complex, error));
      return filling.complexes.list.clear();
    }
  }
  if (options.improve_surface) plan.freedom = &filling.freedom.emplace(input, filling.complexes.list);
}

// From numbers of the complex to those of the input; new points from `first_new` on. Both lists of the complex ascend,
// so that triangles stay in order.
void to_numbers_of_input(const Complex& complex, std::uint64_t first_new, std::span<PartMesh> parts,
                         const TaskRunner& runner) {
  const std::uint64_t given = complex.points.size();
  runner.for_each(parts.size(), [&](std::size_t i) {
    for (std::uint64_t& number : parts[i].vert_to_global)
      number = number < given ? complex.to_input_vert[number] : number - given + first_new;
    for (std::uint32_t& triangle : parts[i].block(BoundaryKind::Triangle).to_entity)
      triangle = complex.to_input_tri[triangle];
  });
}

// The complexes one after the other, on the ranks that host their parts.
void join_complexes(const VolumeInput& input, std::span<const Complex> complexes, std::vector<VolumeParts>&& filled,
                    const SharedWork& work, VolumeParts& result) {
  Communicator& communicator = work.ranks();
  std::vector<volume::NumberedPart> parts;
  result.first_new = input.points.size() + first_number();
  for (std::size_t i = 0; i < complexes.size(); ++i) {
    VolumeParts& of = filled[i];
    to_numbers_of_input(complexes[i], result.first_new + result.new_points, of.parts, work.runner().uninterruptible());
    result.new_points += of.new_points;
    // One part lies where it was made.
    const auto own = of.part_count > 1 ? communicator.parts_of_rank(of.part_count) : std::vector{PartId(0)};
    for (std::size_t p = 0; p < of.parts.size(); ++p)
      parts.push_back({PartId(result.part_count + own[p].value), std::move(of.parts[p])});
    result.part_count += of.part_count;
    std::ranges::move(of.errors, std::back_inserter(result.errors));
    std::ranges::move(of.warnings, std::back_inserter(result.warnings));
    result.figures.add(of.figures);
  }
  if (result.part_count > 0) result.parts = volume::send_home(std::move(parts), result.part_count, communicator);
}

void check(const VolumeInput& input, const VolumeOptions& options, const SharedWork& work) {
  {
    const std::size_t pieces = input.tri_to_vert.size() / kTrianglesPerTask + 1;
    const TraceSpan span(options.trace, "check", work.runner().threads(), pieces);
    const TaskRunner quiet = work.runner().uninterruptible();  // so soon that nobody is asked
    check_input(input, work.rank_count() > 1 ? work : SharedWork(quiet));
  }
  const TraceSpan span(options.trace, "estimate");
  check_goals(options.goals);
  if (!(options.tets_per_part >= 0)) refuse("the number of tets per part must not be negative");
  check_memory(estimate_filling(input), options.max_memory);
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

VolumeParts fill_volume(const VolumeInput& input, const VolumeOptions& options, const SharedWork& work) {
  VolumeParts result;
  work.together([&] {
    volume::FillingPlan plan{input, options, {}};
    Filling filling;
    check(input, options, work);
    plan_filling(plan, work, filling, result);
    const std::span<const Complex> complexes = filling.complexes.list;
    join_complexes(input, complexes, volume::fill_on_ranks(plan, complexes, filling.progress, work), work, result);
  });
  return result;
}

}  // namespace tetloom

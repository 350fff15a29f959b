#include "apps/tetloom/adapt_input.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "apps/tetloom/option_values.hpp"
#include "core/base/lists.hpp"
#include "core/mesh/mesh_access.hpp"
#include "tetloom/io.hpp"
#include "tetloom/metric.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/parts/gather_mesh.hpp"
#include "threading/parts/number_ids.hpp"

namespace tetloom::app {
namespace {

bool needs_fields(const AdaptCommand& command) {
  return !command.metric_field.empty() || !command.hessian_field.empty() || !command.options.transfer.empty();
}

std::string names_of(const std::vector<MeshField>& fields) {
  if (fields.empty()) return "there are none";
  std::string text = "there are";
  for (const MeshField& field : fields) text += (&field == &fields.front() ? " \"" : ", \"") + field.name + '"';
  return text;
}

const MeshField& field_named(const Mesh& mesh, const std::string& name) {
  for (const MeshField& field : mesh.point_fields)
    if (field.name == name) return field;
  throw Error(ErrorCode::InputUnsuitable,
              "the mesh has no field \"" + name + "\" on its points; " + names_of(mesh.point_fields));
}

bool has_field(const std::vector<MeshField>& fields, const std::string& name) {
  return std::any_of(fields.begin(), fields.end(), [&](const MeshField& field) { return field.name == name; });
}

void require_fields(const Mesh& mesh, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (!has_field(mesh.point_fields, name) && !has_field(mesh.cell_fields, name))
      throw Error(ErrorCode::InputUnsuitable, "the mesh has no field \"" + name + "\" to transfer; on its points " +
                                                  names_of(mesh.point_fields) + ", on its cells " +
                                                  names_of(mesh.cell_fields));
}

// The file of that name in text or in binary, whichever there is.
std::filesystem::path find_fields_beside(const std::filesystem::path& path) {
  std::filesystem::path file = fields_beside(path);
  if (!std::filesystem::exists(file)) file.replace_extension(file.extension() == ".sol" ? ".solb" : ".sol");
  if (!std::filesystem::exists(file))
    throw Error(ErrorCode::InputUnsuitable, "fields of '" + path.string() + "' are asked for, but '" +
                                                fields_beside(path).string() + "' is not there");
  return file;
}

void read_fields_beside(const std::filesystem::path& path, Mesh& mesh, const CancelToken& cancel) {
  Solution solution = read_solution(find_fields_beside(path), solution_size(mesh), &cancel);
  mesh.point_fields = std::move(solution.point_fields);
  if (cell_count(mesh) == mesh.tet_to_vert.size()) mesh.cell_fields = std::move(solution.tet_fields);
}

MeshField read_metric_file(const std::filesystem::path& path, const AdaptInput& input, const CancelToken& cancel) {
  Solution solution = input.parts ? read_solution_at({input.points.numbers, 0, 0}, path, input.points.whole, &cancel)
                                  : read_solution(path, solution_size(*input.mesh), &cancel);
  if (solution.point_fields.size() != 1)
    throw Error(ErrorCode::InputUnsuitable, "'" + path.string() + "' must hold one metric at the points, but holds " +
                                                std::to_string(solution.point_fields.size()) + " solutions there");
  return std::move(solution.point_fields[0]);
}

adapt::MetricField from_solution(const AdaptCommand& command, const Mesh& mesh, const TaskRunner& runner) {
  const MeshField& field = field_named(mesh, command.hessian_field);
  if (field.components != 1)
    throw Error(ErrorCode::InputUnsuitable, "--hessian wants a field of one component, and \"" + field.name +
                                                "\" has " + std::to_string(field.components));
  require_consistent(mesh, runner);
  return adapt::metric_from_solution(field.values, {mesh.points, mesh.tet_to_vert}, command.hessian, runner).metric;
}

// In SharedWork::together.
PointsOfRank number_points(const PartitionedMesh& parts, const SharedWork& work) {
  PointsOfRank points;
  std::array<std::int64_t, 1> tets{0};
  work.each([&] {
    for (const PartId id : parts.local()) {
      const PartMesh& part = parts.parts.at(id).mesh;
      points.ids.insert(points.ids.end(), part.vert_to_global.begin(), part.vert_to_global.end());
      tets[0] += static_cast<std::int64_t>(part.block(CellKind::Tet).size());
    }
    sort_unique(points.ids);
  });
  points.numbers = number_ids(points.ids, points.whole.points, work);
  work.sum(tets);
  points.whole.tets = static_cast<std::size_t>(tets[0]);
  return points;
}

// Of what was read for all parts of this rank, the values at the points of one.
template <class Values>
void take_values(const PartMesh& part, const PointsOfRank& points, const MeshField& read, Values& values) {
  for (const std::uint64_t id : part.vert_to_global) {
    const auto at = std::ranges::lower_bound(points.ids, id) - points.ids.begin();
    const auto first = static_cast<std::size_t>(at) * static_cast<std::size_t>(read.components);
    for (std::size_t i = first; i < first + static_cast<std::size_t>(read.components); ++i)
      values.push_back(read.values[i]);
  }
}

// Of slices: a part for each rank, its tets as in the file.
void read_fields_at_slice(const std::filesystem::path& path, const CancelToken& cancel, const SharedWork& work,
                          AdaptInput& input) {
  const PartId id(static_cast<std::size_t>(work.rank()));
  PartMesh& part = input.parts->parts.at(id).mesh;
  std::vector<std::int64_t> tets(static_cast<std::size_t>(work.rank_count()), 0);
  tets[id.value] = static_cast<std::int64_t>(part.block(CellKind::Tet).size());
  work.sum(tets);
  const auto mine = tets.begin() + static_cast<std::ptrdiff_t>(id.value);
  const SolutionShare share{input.points.numbers, static_cast<std::uint64_t>(std::reduce(tets.begin(), mine)),
                            static_cast<std::uint64_t>(*mine)};
  work.each([&] {
    const Solution solution = read_solution_at(share, find_fields_beside(path), input.points.whole, &cancel);
    for (const MeshField& field : solution.point_fields) {
      input.parts->vertex_fields.push_back({field.name, field.components});
      take_values(part, input.points, field, part.vertex_fields.emplace_back(field.name, field.components).values);
    }
    for (const MeshField& field : solution.tet_fields) {
      input.parts->cell_fields.push_back({field.name, field.components});
      part.cell_fields.push_back({field.name, field.components, {}});
      part.cell_fields.back().values[static_cast<std::size_t>(CellKind::Tet)].append(field.values);
    }
  });
}

// Where each rank can have some of all that is asked for.
void read_slices_of(const AdaptCommand& command, const SharedWork& work, const CancelToken& cancel, AdaptInput& input) {
  if (work.rank_count() == 1) return;
  const bool wants_beside = has_fields_beside(command.input) && needs_fields(command);
  std::optional<SlicedMesh> sliced = read_slices(command.input, work.ranks(), work.runner(), &cancel);
  if (!sliced) return;
  input.parts = std::move(sliced->mesh);
  if (command.metric_file.empty() && !wants_beside) return;
  input.points = number_points(*input.parts, work);
  input.points.numbers = input.points.ids, input.points.whole.points = sliced->points;
  if (wants_beside) read_fields_at_slice(command.input, cancel, work, input);
}

// Of the values that were read for all parts of this rank, or of a field of the part.
MeshField metric_at(const PartMesh& part, const AdaptCommand& command, const AdaptInput& input) {
  if (command.metric_file.empty()) {
    const auto field = std::ranges::find(part.vertex_fields, command.metric_field, &VertexField::name);
    return {field->name, field->components, {field->values.begin(), field->values.end()}};
  }
  MeshField values{input.metric.name, input.metric.components, {}};
  take_values(part, input.points, input.metric, values.values);
  return values;
}

}  // namespace

bool has_fields_beside(const std::filesystem::path& mesh) {
  const std::string extension = lower_extension(mesh);
  return extension == ".mesh" || extension == ".meshb";
}

std::filesystem::path fields_beside(const std::filesystem::path& mesh) {
  std::filesystem::path path = mesh;
  return path.replace_extension(lower_extension(mesh) == ".meshb" ? ".solb" : ".sol");
}

AdaptInput read_pieces_of(const AdaptCommand& command, const SharedWork& work, const CancelToken& cancel) {
  AdaptInput input;
  if (!is_piece_list(command.input)) {
    read_slices_of(command, work, cancel, input);
    return input;
  }
  input.parts = read_parts(command.input, work.ranks(), work.runner(), &cancel);
  if (work.rank_count() > 1) {
    if (!command.metric_file.empty()) input.points = number_points(*input.parts, work);
    return input;
  }
  input.mesh = copy_to_all(std::move(*input.parts), work);
  input.parts.reset();
  return input;
}

void read_adapt_input(const AdaptCommand& command, const CancelToken& cancel, AdaptInput& input) {
  if (!input.parts && !input.mesh) input.mesh = read_mesh(command.input, &cancel);
  if (has_fields_beside(command.input)) {
    if (needs_fields(command) && input.mesh) read_fields_beside(command.input, *input.mesh, cancel);
    input.order = adapt::TensorOrder::Medit;
  }
  const Mesh fields = input.parts ? fields_of(*input.parts) : Mesh();
  const Mesh& mesh = input.parts ? fields : *input.mesh;
  require_fields(mesh, command.options.transfer);
  if (!command.hessian_field.empty()) static_cast<void>(field_named(mesh, command.hessian_field));
  if (!command.metric_field.empty()) input.metric = field_named(mesh, command.metric_field);
  if (!command.metric_file.empty()) {
    input.metric = read_metric_file(command.metric_file, input, cancel);
    input.order = adapt::TensorOrder::Medit;
  }
}

PerPart<adapt::MetricField> make_metric_of_parts(const AdaptCommand& command, const AdaptInput& input,
                                                 const TaskRunner& runner) {
  const PartitionedMesh& parts = *input.parts;
  PerPart<adapt::MetricField> metric(parts.part_count(), parts.local());
  for (const PartId id : parts.local()) {
    const PartMesh& part = parts.parts.at(id).mesh;
    metric.at(id) = adapt::metric_from_field(metric_at(part, command, input), input.order, part.points.span(), runner);
    adapt::apply_bounds(metric.at(id), command.hessian.bounds, runner);
  }
  return metric;
}

adapt::MetricField make_metric(const AdaptCommand& command, AdaptInput& input, const TaskRunner& runner) {
  const bool from_values = command.hessian_field.empty();
  adapt::MetricField metric = from_values
                                  ? adapt::metric_from_field(input.metric, input.order, input.mesh->points, runner)
                                  : from_solution(command, *input.mesh, runner);
  input.metric = MeshField();
  if (from_values) adapt::apply_bounds(metric, command.hessian.bounds, runner);
  return metric;
}

}  // namespace tetloom::app

#include "tetloom/partition.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "threading/comm/collectives.hpp"

namespace tetloom {
namespace {

using Row = PartsFigures::Row;

const CellField* find_field(const PartMesh& part, const std::string& name) {
  for (const CellField& field : part.cell_fields)
    if (field.name == name) return &field;
  return nullptr;
}

double weight_of(const PartMesh& part, const std::string& weights) {
  const CellField* field = weights.empty() ? nullptr : find_field(part, weights);
  if (field == nullptr) return static_cast<double>(part.cell_count());
  double sum = 0;
  for (const auto& values : field->values)
    for (const double value : values) sum += value;
  return sum;
}

std::int64_t count_face_neighbours(const Part& part) {
  std::vector<PartId> parts;
  for (const Copy& copy : part.boundary.faces.copies)
    if (parts.empty() || parts.back() != copy.part) parts.push_back(copy.part);
  std::sort(parts.begin(), parts.end());
  return std::unique(parts.begin(), parts.end()) - parts.begin();
}

std::int64_t count_owned_vertices(PartId self, const Part& part) {
  const auto& shared = part.boundary.vertices;
  auto count = static_cast<std::int64_t>(part.mesh.vertex_count() - shared.size());
  for (std::size_t i = 0; i < shared.size(); ++i) count += owner_of(shared.copies_of(i), self) == self ? 1 : 0;
  return count;
}

template <class Value>
double imbalance_of(const std::vector<Row>& rows, const Value& value) {
  double sum = 0, most = 0;
  for (const Row& row : rows) {
    sum += static_cast<double>(value(row));
    most = std::max(most, static_cast<double>(value(row)));
  }
  return sum > 0 ? most * static_cast<double>(rows.size()) / sum - 1 : 0;
}

}  // namespace

void require_weights(const PartitionedMesh& mesh, const std::string& weights) {
  if (weights.empty()) return;
  const auto info = std::find_if(mesh.cell_fields.begin(), mesh.cell_fields.end(),
                                 [&](const FieldInfo& field) { return field.name == weights; });
  if (info == mesh.cell_fields.end())
    throw Error(ErrorCode::InvalidArgument, "the mesh has no cell field '" + weights + "' to take weights from");
  if (info->components != 1)
    throw Error(ErrorCode::InvalidArgument, "the field '" + weights + "' has more than one value per cell");
  run_on_all(*mesh.communicator, [&] {
    for (const PartId part : mesh.local())
      for (const auto& values : find_field(mesh.parts.at(part).mesh, weights)->values)
        for (const double value : values)
          if (!(value > 0) || value > std::numeric_limits<double>::max())
            throw Error(ErrorCode::InvalidArgument,
                        "the field '" + weights + "' has values that are no weights: not positive, or not finite");
  });
}

PartsFigures measure_parts(const PartitionedMesh& mesh, const std::string& weights) {
  require_weights(mesh, weights);
  constexpr std::size_t kColumns = 6;
  // A part lies on one rank, so a sum with the zeros of all others carries the bits of its weight.
  std::vector<std::int64_t> values(kColumns * mesh.part_count(), 0);
  std::array<std::int64_t, 1> shared_faces{};
  for (const PartId id : mesh.local()) {
    const Part& part = mesh.parts.at(id);
    const std::array<std::int64_t, kColumns> row{
        static_cast<std::int64_t>(part.mesh.cell_count()),          static_cast<std::int64_t>(part.mesh.vertex_count()),
        static_cast<std::int64_t>(part.boundary.vertices.size()),   count_face_neighbours(part),
        std::bit_cast<std::int64_t>(weight_of(part.mesh, weights)), count_owned_vertices(id, part)};
    std::copy(row.begin(), row.end(), values.begin() + static_cast<std::ptrdiff_t>(kColumns * id.value));
    shared_faces[0] += static_cast<std::int64_t>(part.boundary.faces.size());
  }
  mesh.communicator->sum(values);
  mesh.communicator->sum(shared_faces);

  PartsFigures figures;
  figures.cut_faces = shared_faces[0] / 2;
  for (std::size_t part = 0; part < mesh.part_count(); ++part) {
    const std::int64_t* row = values.data() + kColumns * part;
    figures.parts.push_back({row[0], row[1], row[2], row[3], std::bit_cast<double>(row[4])});
    figures.elements += row[0];
    figures.vertices += row[5];
    figures.edges += row[3];
  }
  figures.edges /= 2;
  figures.element_imbalance = imbalance_of(figures.parts, [](const Row& row) { return row.elements; });
  figures.vertex_imbalance = imbalance_of(figures.parts, [](const Row& row) { return row.vertices; });
  figures.weight_imbalance = imbalance_of(figures.parts, [](const Row& row) { return row.weight; });
  return figures;
}

}  // namespace tetloom

#include "adapt/transfer/field_transfer.hpp"

#include <algorithm>
#include <cmath>

#include "adapt/transfer/clip_tet.hpp"
#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {
namespace {

constexpr std::size_t kGrain = 1 << 12;

const MeshField* find_field(const std::vector<MeshField>& fields, const std::string& name) {
  const auto at = std::find_if(fields.begin(), fields.end(), [&](const MeshField& f) { return f.name == name; });
  return at == fields.end() ? nullptr : &*at;
}

std::string names_of(const std::vector<MeshField>& fields) {
  std::string text;
  for (const MeshField& field : fields) text += (text.empty() ? "\"" : ", \"") + field.name + '"';
  return text.empty() ? "none" : text;
}

void check_finite(const Mesh& mesh, const MeshField& field) {
  const auto n = static_cast<std::size_t>(field.components);
  const auto begin = field.values.begin(), end = begin + static_cast<std::ptrdiff_t>(mesh.tet_to_vert.size() * n);
  const auto at = std::find_if(begin, end, [](double v) { return !std::isfinite(v); });
  if (at == end) return;
  const auto tet = static_cast<std::size_t>(at - begin) / n;
  throw Error(Diagnostic{ErrorCode::InputUnsuitable,
                         "the cell field \"" + field.name + "\" cannot be transferred: it is not finite everywhere",
                         {},
                         center_of(corners_of(tets_of(mesh), static_cast<std::uint32_t>(tet))),
                         {tet}});
}

std::vector<FieldFigures> measure(const TetView& mesh, const MeshField& field, bool on_cells, const BlockLoop& loop) {
  const auto n = static_cast<std::size_t>(field.components);
  const auto add = [&](std::size_t begin, std::size_t end, std::vector<FieldFigures>& sums) {
    for (std::size_t tet = begin; tet < end; ++tet) {
      const double volume = volume_of(corners_of(mesh, static_cast<std::uint32_t>(tet)));
      for (std::size_t c = 0; c < n; ++c) {
        if (on_cells) {
          sums[c].integral += volume * field.values[tet * n + c];
          sums[c].magnitude += volume * std::abs(field.values[tet * n + c]);
          continue;
        }
        for (const std::uint32_t v : mesh.tets[tet]) {
          sums[c].integral += volume / 4 * field.values[v * n + c];
          sums[c].magnitude += volume / 4 * std::abs(field.values[v * n + c]);
        }
      }
    }
  };
  std::vector<FieldFigures> figures(n);
  for (const auto& block : map_blocks(loop, mesh.tets.size(), kGrain, figures, add))
    for (std::size_t c = 0; c < n; ++c)
      figures[c].integral += block[c].integral, figures[c].magnitude += block[c].magnitude;
  for (std::size_t c = 0; c < n; ++c) {
    FieldFigures& f = figures[c];
    f.least = HUGE_VAL, f.greatest = -HUGE_VAL;
    for (std::size_t i = c; i < field.values.size(); i += n)
      f.least = std::min(f.least, field.values[i]), f.greatest = std::max(f.greatest, field.values[i]);
  }
  return figures;
}

/// All the fields side by side, as one of many components.
std::vector<double> join(const std::vector<const MeshField*>& fields, std::size_t count, std::size_t components) {
  std::vector<double> joined;
  joined.reserve(count * components);
  for (std::size_t i = 0; i < count; ++i) {
    for (const MeshField* field : fields) {
      const auto n = static_cast<std::size_t>(field->components);
      joined.insert(joined.end(), field->values.begin() + static_cast<std::ptrdiff_t>(i * n),
                    field->values.begin() + static_cast<std::ptrdiff_t>((i + 1) * n));
    }
  }
  return joined;
}

MeshField take_apart(std::span<const double> joined, std::size_t components, std::size_t first,
                     const MeshField& source) {
  MeshField field{source.name, source.components, {}};
  field.values.reserve(joined.size() / components * static_cast<std::size_t>(source.components));
  for (std::size_t at = first; at < joined.size(); at += components)
    for (int c = 0; c < source.components; ++c) field.values.push_back(joined[at + static_cast<std::size_t>(c)]);
  return field;
}

std::size_t count_components(const std::vector<const MeshField*>& fields) {
  std::size_t count = 0;
  for (const MeshField* field : fields) count += static_cast<std::size_t>(field->components);
  return count;
}

std::vector<MeshField> take_all_apart(std::span<const double> joined, const std::vector<const MeshField*>& sources) {
  std::vector<MeshField> fields;
  const std::size_t components = count_components(sources);
  std::size_t first = 0;
  for (const MeshField* source : sources) {
    fields.push_back(take_apart(joined, components, first, *source));
    first += static_cast<std::size_t>(source->components);
  }
  return fields;
}

FieldTransfer compare(const TetView& from, const MeshField& before, const TetView& to, const MeshField& after,
                      bool on_cells, const BlockLoop& loop) {
  const auto old = measure(from, before, on_cells, loop), now = measure(to, after, on_cells, loop);
  FieldTransfer transfer{before.name, on_cells, {}};
  for (std::size_t c = 0; c < old.size(); ++c) transfer.components.push_back({old[c], now[c]});
  return transfer;
}

}  // namespace

void check_transfer(const Mesh& mesh, const std::vector<std::string>& names) {
  const auto refuse = [](const std::string& message) { throw Error(ErrorCode::InvalidArgument, message); };
  for (const std::string& name : names) {
    if (std::count(names.begin(), names.end(), name) > 1)
      refuse("the field \"" + name + "\" is to be transferred twice");
    const MeshField* const on_cells = find_field(mesh.cell_fields, name);
    if (!on_cells && !find_field(mesh.point_fields, name))
      refuse("the mesh has no field \"" + name + "\" to transfer; on points there is " + names_of(mesh.point_fields) +
             ", on cells " + names_of(mesh.cell_fields));
    if (on_cells) check_finite(mesh, *on_cells);
  }
}

FieldCarrier::FieldCarrier(const Mesh& from, const BackgroundMesh& background, const std::vector<std::string>& names)
    : from_(from), background_(background) {
  for (const std::string& name : names) {
    if (const MeshField* const field = find_field(from.cell_fields, name)) on_tets_.push_back(field);
    if (const MeshField* const field = find_field(from.point_fields, name)) on_points_.push_back(field);
  }
  point_components_ = count_components(on_points_), tet_components_ = count_components(on_tets_);
}

CellSource FieldCarrier::tet_source(std::span<const double> values) const {
  return {background_, from_.tet_to_entity, {values, tet_components_}};
}

CarriedFields FieldCarrier::carry(const TetsInRegions& to, std::size_t point_count,
                                  std::span<const BackgroundPlace> places, CellReconstruction shape,
                                  const TaskRunner& runner) const {
  CarriedFields carried;
  std::vector<MeshField> fields;
  for (const MeshField* field : on_points_)
    fields.push_back(background_.interpolate(*field, places.first(point_count), runner));
  std::vector<const MeshField*> pointers;
  for (const MeshField& field : fields) pointers.push_back(&field);
  carried.on_points = join(pointers, point_count, point_components_);
  if (on_tets_.empty()) return carried;
  const std::vector<double> before = join(on_tets_, from_.tet_to_vert.size(), tet_components_);
  carried.on_tets = average_cells(tet_source(before), to, places, shape, runner);
  return carried;
}

std::vector<FieldTransfer> FieldCarrier::finish(CarriedFields&& carried, Mesh& to, const TaskRunner& runner) const {
  if (!on_tets_.empty()) {
    const std::vector<double> before = join(on_tets_, from_.tet_to_vert.size(), tet_components_);
    put_right_cells(tet_source(before), {tets_of(to), to.tet_to_entity}, carried.on_tets, runner);
  }
  to.point_fields = take_all_apart(carried.on_points, on_points_);
  to.cell_fields = take_all_apart(carried.on_tets, on_tets_);
  carried = CarriedFields();
  std::vector<FieldTransfer> transfers;
  for (std::size_t i = 0; i < on_points_.size(); ++i)
    transfers.push_back(compare(background_.mesh(), *on_points_[i], tets_of(to), to.point_fields[i], false, runner));
  for (std::size_t i = 0; i < on_tets_.size(); ++i)
    transfers.push_back(compare(background_.mesh(), *on_tets_[i], tets_of(to), to.cell_fields[i], true, runner));
  return transfers;
}

}  // namespace tetloom::adapt

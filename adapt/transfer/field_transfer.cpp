#include "adapt/transfer/field_transfer.hpp"

#include <algorithm>
#include <cmath>

#include "adapt/transfer/clip_tet.hpp"
#include "core/base/exact_sum.hpp"
#include "core/base/grain.hpp"
#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {
namespace {

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

/// Joined fields, on points or on tets. Non-owning.
struct JoinedValues {
  std::span<const double> values;
  std::size_t components = 1;
  bool on_cells = false;
};

/// Exact, so neither blocks nor ranks matter.
struct FieldSums {
  std::vector<ExactSum> integrals, magnitudes;
  explicit FieldSums(std::size_t components) : integrals(components), magnitudes(components) {}
};

FieldSums sums_of(const TetView& mesh, const JoinedValues& of, const BlockLoop& loop) {
  const std::size_t n = of.components;
  const auto add = [&](std::size_t begin, std::size_t end, FieldSums& sums) {
    for (std::size_t tet = begin; tet < end; ++tet) {
      const double volume = volume_of(corners_of(mesh, static_cast<std::uint32_t>(tet)));
      const auto add_value = [&](std::size_t at, double share) {
        for (std::size_t c = 0; c < n; ++c) {
          const double value = share * of.values[at * n + c];
          sums.integrals[c].add(value), sums.magnitudes[c].add(std::abs(value));
        }
      };
      if (of.on_cells)
        add_value(tet, volume);
      else
        for (const std::uint32_t v : mesh.tets[tet]) add_value(v, volume / 4);
    }
  };
  FieldSums all(n);
  for (const FieldSums& block : map_blocks(loop, mesh.tets.size(), kElementGrain, all, add))
    for (std::size_t c = 0; c < n; ++c)
      all.integrals[c].add(block.integrals[c]), all.magnitudes[c].add(block.magnitudes[c]);
  return all;
}

/// Of the tets and values of all ranks, component by component. `counts`: of the values' places; empty: all. In
/// SharedWork::together.
std::vector<FieldFigures> figures_of(const TetView& own, const JoinedValues& of, std::span<const std::uint8_t> counts,
                                     const SharedWork& work) {
  const std::size_t n = of.components;
  FieldSums sums(0);
  std::vector<double> ends(2 * n, -HUGE_VAL);
  work.each([&] {
    sums = sums_of(own, of, work.runner());
    for (std::size_t i = 0; i < of.values.size(); ++i) {
      if (!counts.empty() && counts[i / n] == 0) continue;
      double* const of_component = &ends[i % n * 2];
      of_component[0] = std::max(of_component[0], -of.values[i]);
      of_component[1] = std::max(of_component[1], of.values[i]);
    }
  });
  work.sum(sums.integrals), work.sum(sums.magnitudes), work.max(ends);
  std::vector<FieldFigures> figures;
  for (std::size_t c = 0; c < n; ++c)
    figures.push_back({sums.integrals[c].value(), -ends[2 * c], ends[2 * c + 1], sums.magnitudes[c].value()});
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

std::vector<FieldInfo> infos_of(const std::vector<const MeshField*>& fields) {
  std::vector<FieldInfo> infos;
  for (const MeshField* field : fields) infos.push_back({field->name, field->components});
  return infos;
}

}  // namespace

std::vector<const MeshField*> fields_named(const std::vector<MeshField>& all, const std::vector<std::string>& names) {
  std::vector<const MeshField*> fields;
  for (const std::string& name : names)
    if (const MeshField* const field = find_field(all, name)) fields.push_back(field);
  return fields;
}

namespace {

void add_transfers(const std::vector<const MeshField*>& fields, bool on_cells, const std::vector<FieldFigures>& before,
                   const std::vector<FieldFigures>& after, std::vector<FieldTransfer>& transfers) {
  std::size_t next = 0;
  for (const MeshField* field : fields) {
    FieldTransfer& transfer = transfers.emplace_back(FieldTransfer{field->name, on_cells, {}});
    for (int c = 0; c < field->components; ++c, ++next) transfer.components.push_back({before[next], after[next]});
  }
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

JoinedCells join_cells(const Mesh& mesh, std::size_t tet_count, const std::vector<std::string>& names) {
  const std::vector<const MeshField*> fields = fields_named(mesh.cell_fields, names);
  const std::size_t n = count_components(fields);
  return {join(fields, tet_count, n), n};
}

FieldsBefore fields_before(const FieldPlaces& from, const std::vector<std::string>& names, const SharedWork& work) {
  const std::vector<const MeshField*> on_points = fields_named(from.fields.point_fields, names);
  const std::size_t n = count_components(on_points);
  FieldsBefore before;
  if (n > 0) {
    const std::vector<double> values = join(on_points, from.tets.mesh.points.size(), n);
    before.on_points = figures_of(from.own_tets(), {values, n, false}, from.is_own, work);
  }
  const JoinedCells cells = join_cells(from.fields, from.tets.mesh.tets.size(), names);
  if (cells.components > 0) {
    const auto own =
        std::span(cells.values).subspan(from.begin * cells.components, (from.end - from.begin) * cells.components);
    const TetsInRegions tets{from.own_tets(), from.tets.regions.subspan(from.begin, from.end - from.begin)};
    before.on_tets = figures_of(tets.mesh, {own, cells.components, true}, {}, work);
    before.regions = sum_cells(tets, {own, cells.components}, work);
  }
  return before;
}

FieldCarrier::FieldCarrier(const Mesh& from, const BackgroundMesh& background, BackgroundTiles* tiles,
                           const std::vector<std::string>& names, FieldsBefore&& before)
    : from_(from),
      background_(background),
      tiles_(tiles),
      names_(names),
      on_points_(fields_named(from.point_fields, names)),
      on_tets_(fields_named(from.cell_fields, names)),
      point_components_(count_components(on_points_)),
      tet_components_(count_components(on_tets_)),
      before_(std::move(before)) {}

void FieldCarrier::put_values_at(const BackgroundPlace& place, double* values) const {
  if (tiles_ != nullptr) return tiles_->fields_at(place, {values, point_components_});
  for (const MeshField* field : on_points_)
    for (int c = 0; c < field->components; ++c) *values++ = background_.value_at(*field, c, place);
}

CarriedFields FieldCarrier::carry(const TetsInRegions& to, std::span<const BackgroundTet> hints,
                                  CellReconstruction shape, const SharedWork& work) const {
  CarriedFields carried;
  carried.on_points.resize(hints.size() * point_components_);
  std::vector<BackgroundPlace> places(hints.size());
  const auto tile_of = [&](std::size_t v) { return tiles_->tile_of(hints[v]); };
  look_up_all(tiles_, hints.size(), kElementGrain, work, tile_of, [&] {
    return [&](std::size_t v) {
      places[v] = background_.locate(to.mesh.points[v], hints[v]);
      put_values_at(places[v], carried.on_points.data() + v * point_components_);
    };
  });
  if (!on_tets_.empty()) carried.on_tets = carry_cells(to, places, shape, work);
  return carried;
}

std::vector<double> FieldCarrier::carry_cells(const TetsInRegions& to, std::span<const BackgroundPlace> places,
                                              CellReconstruction shape, const SharedWork& work) const {
  if (tiles_ != nullptr) return average_cells({background_, *tiles_, tet_components_}, to, places, work);
  const TetView from = background_.mesh();
  const std::span<const std::uint32_t> regions = from_.tet_to_entity;
  const JoinedCells cells = join_cells(from_, from.tets.size(), names_);
  std::vector<Vec3> slopes;
  if (shape == CellReconstruction::Linear)
    slopes = limited_slopes({from, background_.links(), regions, 0, from.tets.size()}, cells, work.runner());
  return average_cells({background_, regions, cells, slopes}, to, places, work);
}

std::vector<double> FieldCarrier::average_cells(const OldTets& from, const TetsInRegions& to,
                                                std::span<const BackgroundPlace> places, const SharedWork& work) const {
  std::vector<double> values(to.regions.size() * tet_components_);
  const auto tile_of = [&](std::size_t tet) { return tiles_->tile_of(places[to.mesh.tets[tet][0]].tet); };
  look_up_all(tiles_, to.regions.size(), kSearchGrain, work, tile_of, [&] {
    return [&, averager = CellAverager(from, before_.regions, to, places, work.runner())](std::size_t tet) mutable {
      averager.put_means(tet, &values[tet * tet_components_]);
    };
  });
  return values;
}

std::vector<FieldTransfer> FieldCarrier::finish(const TetsInRegions& to, CarriedFields& carried,
                                                const SharedWork& work) const {
  std::vector<FieldTransfer> transfers;
  if (!on_points_.empty()) {
    const auto after = figures_of(to.mesh, {carried.on_points, point_components_, false}, {}, work);
    add_transfers(on_points_, false, before_.on_points, after, transfers);
  }
  if (!on_tets_.empty()) {
    const SumsByRegion sums = sum_cells(to, {carried.on_tets, tet_components_}, work);
    work.each([&] { put_right_cells(before_.regions, sums, to.regions, carried.on_tets, work.runner()); });
    const auto after = figures_of(to.mesh, {carried.on_tets, tet_components_, true}, {}, work);
    add_transfers(on_tets_, true, before_.on_tets, after, transfers);
  }
  return transfers;
}

void FieldCarrier::give(CarriedFields&& carried, Mesh& to) const {
  to.point_fields = take_all_apart(carried.on_points, on_points_);
  to.cell_fields = take_all_apart(carried.on_tets, on_tets_);
  carried = CarriedFields();
}

std::vector<FieldInfo> FieldCarrier::infos_on_points() const { return infos_of(on_points_); }
std::vector<FieldInfo> FieldCarrier::infos_on_tets() const { return infos_of(on_tets_); }

}  // namespace tetloom::adapt

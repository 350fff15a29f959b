#include "adapt/transfer/field_transfer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "adapt/transfer/clip_tet.hpp"
#include "core/base/exact_sum.hpp"
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

/// Joined fields, on points or on tets. Non-owning.
struct JoinedValues {
  std::span<const double> values;
  std::size_t components = 1;
  bool on_cells = false;
};

/// What a component is over some tets.
struct FieldSums {
  ExactSum integral, magnitude;
};

std::vector<FieldSums> sums_of(const TetView& mesh, const JoinedValues& of, const BlockLoop& loop) {
  const std::size_t n = of.components;
  const auto add = [&](std::size_t begin, std::size_t end, std::vector<FieldSums>& sums) {
    for (std::size_t tet = begin; tet < end; ++tet) {
      const double volume = volume_of(corners_of(mesh, static_cast<std::uint32_t>(tet)));
      const auto add_value = [&](std::size_t at, double share) {
        for (std::size_t c = 0; c < n; ++c) {
          const double value = share * of.values[at * n + c];
          sums[c].integral.add(value), sums[c].magnitude.add(std::abs(value));
        }
      };
      if (of.on_cells)
        add_value(tet, volume);
      else
        for (const std::uint32_t v : mesh.tets[tet]) add_value(v, volume / 4);
    }
  };
  std::vector<FieldSums> all(n);
  for (const auto& block : map_blocks(loop, mesh.tets.size(), kGrain, std::vector<FieldSums>(n), add))
    for (std::size_t c = 0; c < n; ++c)
      all[c].integral.add(block[c].integral), all[c].magnitude.add(block[c].magnitude);
  return all;
}

/// Without extremes.
std::vector<FieldFigures> integrals_of(const TetView& mesh, const JoinedValues& of, const BlockLoop& loop) {
  std::vector<FieldFigures> figures;
  for (const FieldSums& sums : sums_of(mesh, of, loop))
    figures.push_back({sums.integral.value(), 0, 0, sums.magnitude.value()});
  return figures;
}

void note_extremes(const JoinedValues& of, std::vector<FieldFigures>& figures) {
  for (FieldFigures& f : figures) f.least = HUGE_VAL, f.greatest = -HUGE_VAL;
  for (std::size_t i = 0; i < of.values.size(); ++i) {
    FieldFigures& f = figures[i % of.components];
    f.least = std::min(f.least, of.values[i]), f.greatest = std::max(f.greatest, of.values[i]);
  }
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

/// What all ranks have put for their parts, added up part after part.
template <class Sums>
std::vector<Sums> add_up(const SharedWork& work, std::span<const Sums> of_parts, std::size_t count,
                         const std::function<void(const Sums&, Sums&)>& add) {
  const std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) { writer.put_array(of_parts); });
  std::vector<Sums> all(count);
  for (const Bytes& bytes : given) {
    const auto sums = MessageReader(bytes).get_view<Sums>();
    for (std::size_t i = 0; i < sums.size(); ++i) add(sums[i], all[i % count]);
  }
  return all;
}

void add_transfers(const std::vector<const MeshField*>& fields, bool on_cells,
                   const std::array<std::vector<FieldFigures>, 2>& figures, std::vector<FieldTransfer>& transfers) {
  std::size_t next = 0;
  for (const MeshField* field : fields) {
    FieldTransfer& transfer = transfers.emplace_back(FieldTransfer{field->name, on_cells, {}});
    for (int c = 0; c < field->components; ++c, ++next)
      transfer.components.push_back({figures[0][next], figures[1][next]});
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

FieldCarrier::FieldCarrier(const Mesh& from, const BackgroundMesh& background, const std::vector<std::string>& names)
    : from_(from), background_(background) {
  for (const std::string& name : names) {
    if (const MeshField* const field = find_field(from.cell_fields, name)) on_tets_.push_back(field);
    if (const MeshField* const field = find_field(from.point_fields, name)) on_points_.push_back(field);
  }
  point_components_ = count_components(on_points_), tet_components_ = count_components(on_tets_);
}

FieldCarrier::FieldCarrier(const Mesh& from, const BackgroundMesh& background, const std::vector<std::string>& names,
                           std::vector<FieldFigures>&& before)
    : FieldCarrier(from, background, names) {
  before_ = std::move(before);
}

bool carries_on_tets(const Mesh& mesh, const std::vector<std::string>& names) {
  return std::any_of(names.begin(), names.end(),
                     [&](const std::string& name) { return find_field(mesh.cell_fields, name) != nullptr; });
}

std::vector<FieldFigures> figures_before(const MeshSlice& slice, const TetView& own,
                                         const std::vector<std::string>& names, const SharedWork& work) {
  std::vector<const MeshField*> fields;
  for (const std::string& name : names)
    if (const MeshField* const field = find_field(slice.mesh.point_fields, name)) fields.push_back(field);
  const std::size_t n = count_components(fields);
  const std::vector<double> joined = join(fields, slice.to_vert_number.size(), n);
  std::vector<FieldSums> sums = sums_of(own, {joined, n, false}, work.runner());
  std::vector<double> ends(2 * n, -HUGE_VAL);
  for (std::size_t i = 0; i < joined.size(); ++i) {
    if (slice.is_own[i / n] == 0) continue;
    double* const of_component = &ends[i % n * 2];
    of_component[0] = std::max(of_component[0], -joined[i]), of_component[1] = std::max(of_component[1], joined[i]);
  }
  work.max(ends);
  std::vector<FieldFigures> figures;
  const OwnTets shared = slice.own_tets(work);
  for (std::size_t c = 0; c < n; ++c) {
    shared.add_up(sums[c].integral), shared.add_up(sums[c].magnitude);
    figures.push_back({sums[c].integral.value(), -ends[2 * c], ends[2 * c + 1], sums[c].magnitude.value()});
  }
  return figures;
}

CellSource FieldCarrier::tet_source(std::span<const double> values) const {
  return {background_, from_.tet_to_entity, {values, tet_components_}};
}

CarriedFields FieldCarrier::carry(const TetsInRegions& to, std::span<const BackgroundPlace> places,
                                  CellReconstruction shape, const TaskRunner& runner) const {
  CarriedFields carried;
  std::vector<MeshField> fields;
  for (const MeshField* field : on_points_) fields.push_back(background_.interpolate(*field, places, runner));
  std::vector<const MeshField*> pointers;
  for (const MeshField& field : fields) pointers.push_back(&field);
  carried.on_points = join(pointers, places.size(), point_components_);
  if (on_tets_.empty()) return carried;
  const std::vector<double> before = join(on_tets_, background_.mesh().tets.size(), tet_components_);
  carried.on_tets = average_cells(tet_source(before), to, places, shape, runner);
  return carried;
}

void FieldCarrier::put_right(const TetsByPart& to, std::vector<double>& on_tets, const SharedWork& work) const {
  const std::size_t n = tet_components_;
  std::vector<double> values;
  std::vector<RegionIntegrals> before, of_parts;
  work.each([&] {
    values = join(on_tets_, background_.mesh().tets.size(), n);
    const CellSource source = tet_source(values);
    before = sum_cells(source, {background_.mesh(), source.regions}, values, work.runner());
    for (std::size_t p = 0; p < to.part_count(); ++p) {
      const auto own = std::span<const double>(on_tets).subspan(to.first(p) * n, to.count(p) * n);
      const auto sums = sum_cells(source, to.part(p), own, work.runner());
      of_parts.insert(of_parts.end(), sums.begin(), sums.end());
    }
  });
  const std::vector<RegionIntegrals> after = add_up<RegionIntegrals>(
      work, of_parts, before.size(), [](const RegionIntegrals& part, RegionIntegrals& all) { all.add(part); });
  work.each([&] { put_right_cells(tet_source(values), before, after, to.tets.regions, on_tets, work.runner()); });
}

std::vector<FieldTransfer> FieldCarrier::finish(const TetsByPart& to, CarriedFields& carried,
                                                const SharedWork& work) const {
  std::vector<FieldTransfer> transfers;
  if (!on_tets_.empty()) put_right(to, carried.on_tets, work);
  for (const bool on_cells : {false, true}) {
    const auto& fields = on_cells ? on_tets_ : on_points_;
    if (fields.empty()) continue;
    const auto figures = compare(to, on_cells ? carried.on_tets : carried.on_points, on_cells, work);
    add_transfers(fields, on_cells, figures, transfers);
  }
  return transfers;
}

std::vector<FieldFigures> FieldCarrier::find_before(bool on_cells, const BlockLoop& loop) const {
  const std::size_t n = on_cells ? tet_components_ : point_components_;
  const TetView from = background_.mesh();
  const std::vector<double> given =
      join(on_cells ? on_tets_ : on_points_, on_cells ? from.tets.size() : from.points.size(), n);
  std::vector<FieldFigures> before = integrals_of(from, {given, n, on_cells}, loop);
  note_extremes({given, n, on_cells}, before);
  return before;
}

// Of each component, before and after.
std::array<std::vector<FieldFigures>, 2> FieldCarrier::compare(const TetsByPart& to, std::span<const double> carried,
                                                               bool on_cells, const SharedWork& work) const {
  const std::size_t n = on_cells ? tet_components_ : point_components_;
  std::vector<FieldFigures> before, of_parts, own(n);
  work.each([&] {
    before = before_.empty() ? find_before(on_cells, work.runner()) : before_;
    for (std::size_t p = 0; p < to.part_count(); ++p) {
      const std::span<const double> values = on_cells ? carried.subspan(to.first(p) * n, to.count(p) * n) : carried;
      const auto sums = integrals_of(to.part(p).mesh, {values, n, on_cells}, work.runner());
      of_parts.insert(of_parts.end(), sums.begin(), sums.end());
    }
    note_extremes({carried, n, on_cells}, own);
  });
  std::vector<FieldFigures> after =
      add_up<FieldFigures>(work, of_parts, n, [](const FieldFigures& part, FieldFigures& all) {
        all.integral += part.integral, all.magnitude += part.magnitude;
      });
  std::vector<double> ends;
  for (const FieldFigures& f : own) ends.insert(ends.end(), {-f.least, f.greatest});
  work.max(ends);
  for (std::size_t c = 0; c < n; ++c) after[c].least = -ends[2 * c], after[c].greatest = ends[2 * c + 1];
  return {std::move(before), std::move(after)};
}

void FieldCarrier::give(CarriedFields&& carried, Mesh& to) const {
  to.point_fields = take_all_apart(carried.on_points, on_points_);
  to.cell_fields = take_all_apart(carried.on_tets, on_tets_);
  carried = CarriedFields();
}

std::vector<FieldInfo> FieldCarrier::infos_on_points() const { return infos_of(on_points_); }
std::vector<FieldInfo> FieldCarrier::infos_on_tets() const { return infos_of(on_tets_); }

}  // namespace tetloom::adapt

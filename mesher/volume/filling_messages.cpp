#include "mesher/volume/filling_messages.hpp"

#include "core/base/codec.hpp"

namespace tetloom::volume {

namespace {

using tets::OptimizeReport;

constexpr std::array kFillingCounts{&FillingFigures::core_tets, &FillingFigures::shell_tets,
                                    &FillingFigures::worker_complexes, &FillingFigures::missing_triangles,
                                    &FillingFigures::recovery_points};
constexpr std::array kPartsCounts{&FillingPartsFigures::parts, &FillingPartsFigures::asked,
                                  &FillingPartsFigures::asking_rounds, &FillingPartsFigures::given_up};
constexpr std::array kOptimizeCounts{&OptimizeReport::edges_removed,
                                     &OptimizeReport::vertices_moved,
                                     &OptimizeReport::points_inserted,
                                     &OptimizeReport::vertices_removed,
                                     &OptimizeReport::edges_swapped,
                                     &OptimizeReport::vertices_slid,
                                     &OptimizeReport::below_goal,
                                     &OptimizeReport::below_dihedral,
                                     &OptimizeReport::forced,
                                     &OptimizeReport::forced_by_angles,
                                     &OptimizeReport::forced_by_triangles,
                                     &OptimizeReport::forced_by_points,
                                     &OptimizeReport::tets};
constexpr std::array kOptimizeValues{&OptimizeReport::least_before, &OptimizeReport::mean_before,
                                     &OptimizeReport::least, &OptimizeReport::mean, &OptimizeReport::least_dihedral};

template <class T, class Members>
void put_members(MessageWriter& writer, const T& from, const Members& members) {
  for (const auto member : members) writer.put(from.*member);
}
template <class T, class Members>
void get_members(MessageReader& reader, T& to, const Members& members) {
  for (const auto member : members) to.*member = reader.get<std::remove_cvref_t<decltype(to.*member)>>();
}

template <class T>
void put_list(MessageWriter& writer, const std::vector<T>& values) {
  writer.put_array(std::span<const T>(values));
}

void put_acute_tet(MessageWriter& writer, const AcuteTet& tet) {
  writer.put(tet.angle);
  writer.put(tet.point);
  writer.put(tet.cause);
  writer.put(tet.cause_angle);
  writer.put(tet.cause_length);
  put_list(writer, tet.triangles);
  put_list(writer, tet.points);
  put_entities(writer, tet.entities);
}

AcuteTet get_acute_tet(MessageReader& reader) {
  AcuteTet tet;
  tet.angle = reader.get<double>();
  tet.point = reader.get<Vec3>();
  tet.cause = reader.get<AngleCause>();
  tet.cause_angle = reader.get<double>();
  tet.cause_length = reader.get<double>();
  tet.triangles = reader.get_array<std::array<std::uint32_t, 3>>();
  tet.points = reader.get_array<std::uint32_t>();
  tet.entities = get_entities(reader);
  return tet;
}

}  // namespace

void put_figures(MessageWriter& writer, const FillingFigures& figures) {
  put_members(writer, figures, kFillingCounts);
  writer.put(figures.seconds);
  put_members(writer, figures.parts, kPartsCounts);
  writer.put(figures.parts.strips);
  put_text(writer, figures.parts.given_up_why);
  put_members(writer, figures.optimizer, kOptimizeCounts);
  put_members(writer, figures.optimizer, kOptimizeValues);
  writer.put(static_cast<std::uint64_t>(figures.optimizer.acute_tets.size()));
  for (const AcuteTet& tet : figures.optimizer.acute_tets) put_acute_tet(writer, tet);
}

FillingFigures get_figures(MessageReader& reader) {
  FillingFigures figures;
  get_members(reader, figures, kFillingCounts);
  figures.seconds = reader.get<FillingFigures::Seconds>();
  get_members(reader, figures.parts, kPartsCounts);
  figures.parts.strips = reader.get<decltype(figures.parts.strips)>();
  figures.parts.given_up_why = get_text(reader);
  get_members(reader, figures.optimizer, kOptimizeCounts);
  get_members(reader, figures.optimizer, kOptimizeValues);
  figures.optimizer.acute_tets.resize(reader.get<std::uint64_t>());
  for (AcuteTet& tet : figures.optimizer.acute_tets) tet = get_acute_tet(reader);
  return figures;
}

void put_part(MessageWriter& writer, const PartMesh& part) {
  constexpr std::size_t kLengthsAndGaps = 6 * 16;  // of the arrays below
  const PartView view = view_of(part);
  writer.reserve(view.points.size_bytes() + view.vert_to_global.size_bytes() + view.tet_to_vert.size_bytes() +
                 view.tet_to_region.size_bytes() + view.tri_to_vert.size_bytes() + view.triangles.size_bytes() +
                 kLengthsAndGaps);
  writer.put_array(view.points);
  writer.put_array(view.vert_to_global);
  for (const auto list : {view.tet_to_vert, view.tet_to_region, view.tri_to_vert, view.triangles})
    writer.put_array(list);
}

PartMesh get_part(MessageReader& reader) {
  const PartView view = get_view(reader);
  PartMesh part;
  part.points.append(view.points);
  part.vert_to_global.append(view.vert_to_global);
  part.block(CellKind::Tet).to_vert.append(view.tet_to_vert);
  part.block(CellKind::Tet).to_region.append(view.tet_to_region);
  part.block(BoundaryKind::Triangle).to_vert.append(view.tri_to_vert);
  part.block(BoundaryKind::Triangle).to_entity.append(view.triangles);
  return part;
}

PartView view_of(const PartMesh& part) {
  const CellBlock& tets = part.block(CellKind::Tet);
  const BoundaryBlock& triangles = part.block(BoundaryKind::Triangle);
  return {part.points, part.vert_to_global, tets.to_vert, tets.to_region, triangles.to_vert, triangles.to_entity};
}

PartView get_view(MessageReader& reader) {
  PartView part;
  part.points = reader.get_view<Vec3>();
  part.vert_to_global = reader.get_view<std::uint64_t>();
  for (const auto list :
       {&PartView::tet_to_vert, &PartView::tet_to_region, &PartView::tri_to_vert, &PartView::triangles})
    part.*list = reader.get_view<std::uint32_t>();
  return part;
}

}  // namespace tetloom::volume

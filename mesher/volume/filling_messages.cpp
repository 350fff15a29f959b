#include "mesher/volume/filling_messages.hpp"

#include "threading/comm/codec.hpp"

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
  tet.triangles = reader.get_array<std::array<std::uint32_t, 3>>();
  tet.points = reader.get_array<std::uint32_t>();
  tet.entities = get_entities(reader);
  return tet;
}

template <class T>
GrowingArray<T> get_growing(MessageReader& reader) {
  return GrowingArray<T>(reader.get_view<T>());
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

void put_part(MessageWriter& writer, const VolumePart& part) {
  constexpr std::size_t kLengthsAndGaps = 6 * 16;  // of the arrays below
  writer.reserve(part.points.span().size_bytes() + part.vert_to_number.span().size_bytes() +
                 part.tet_to_vert.span().size_bytes() + part.tet_to_region.span().size_bytes() +
                 std::span(part.triangles).size_bytes() + std::span(part.tri_to_vert).size_bytes() + kLengthsAndGaps);
  writer.put_array(part.points.span());
  writer.put_array(part.vert_to_number.span());
  writer.put_array(part.tet_to_vert.span());
  writer.put_array(part.tet_to_region.span());
  put_list(writer, part.triangles);
  put_list(writer, part.tri_to_vert);
}

VolumePart get_part(MessageReader& reader) {
  VolumePart part;
  part.points = get_growing<Vec3>(reader);
  part.vert_to_number = get_growing<std::uint64_t>(reader);
  part.tet_to_vert = get_growing<std::uint32_t>(reader);
  part.tet_to_region = get_growing<std::uint32_t>(reader);
  part.triangles = reader.get_array<std::uint32_t>();
  part.tri_to_vert = reader.get_array<std::array<std::uint32_t, 3>>();
  return part;
}

VolumePartView view_of(const VolumePart& part) {
  return {part.points, part.vert_to_number, part.tet_to_vert, part.tet_to_region, part.triangles, part.tri_to_vert};
}

VolumePartView get_view(const Bytes& bytes) {
  MessageReader reader(bytes);
  VolumePartView part;
  part.points = reader.get_view<Vec3>();
  part.vert_to_number = reader.get_view<std::uint64_t>();
  part.tet_to_vert = reader.get_view<std::uint32_t>();
  part.tet_to_region = reader.get_view<std::uint32_t>();
  part.triangles = reader.get_view<std::uint32_t>();
  part.tri_to_vert = reader.get_view<std::array<std::uint32_t, 3>>();
  return part;
}

}  // namespace tetloom::volume

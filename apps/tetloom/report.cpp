#include "apps/tetloom/report.hpp"

#include <sys/resource.h>

#include "core/io/atomic_file.hpp"

namespace tetloom::app {
namespace {

using Json = nlohmann::ordered_json;

/// Corners sharper than this are listed by face, see `sharp_faces`.
constexpr double kSharpAngleDeg = 20;

Json entity_json(ModelEntity entity, const std::string& name) {
  return {{"dim", entity.dim}, {"id", entity.tag()}, {"name", name}};
}

Json entities_json(const std::vector<NamedEntity>& entities) {
  Json list = Json::array();
  for (const NamedEntity& named : entities) list.push_back(entity_json(named.entity, named.name));
  return list;
}

Json cause_json(AngleCause cause) {
  switch (cause) {
    case AngleCause::SurfaceAngle: return "surface_angle";
    case AngleCause::SurfaceTriangle: return "surface_triangle";
    case AngleCause::SurfacePoints: return "surface_points";
    case AngleCause::NarrowRegion: return "narrow_region";
    case AngleCause::NotForced: break;
  }
  return nullptr;
}

Json acute_tet_json(const AcuteTet& tet) {
  return {{"dihedral_deg", tet.angle},
          {"point", point_json(tet.point)},
          {"cause", cause_json(tet.cause)},
          {"cause_deg", tet.cause_angle > 0 ? Json(tet.cause_angle) : Json(nullptr)},
          {"cause_length", tet.cause_length > 0 ? Json(tet.cause_length) : Json(nullptr)},
          {"entities", entities_json(tet.entities)}};
}

Json diagnostics_json(const std::vector<Diagnostic>& diagnostics) {
  Json list = Json::array();
  for (const Diagnostic& diagnostic : diagnostics) list.push_back(to_json(diagnostic));
  return list;
}

/// Faces with corners below 20 degrees: those that bound the quality of the volume mesh.
Json sharp_faces(const RunReport& report) {
  Json list = Json::array();
  for (const FaceQuality& face : report.quality->triangles.faces) {
    if (face.min_angle_deg >= kSharpAngleDeg || face.face == ModelFaceId::kNone) continue;
    const auto& names = report.entities[2];
    Json entry = entity_json(ModelEntity(2, face.face), face.face < names.size() ? names[face.face].name : "");
    entry["min_angle_deg"] = face.min_angle_deg;
    list.push_back(std::move(entry));
  }
  return list;
}

Json surface_quality_json(const RunReport& report) {
  const TriangleQuality& triangles = report.quality->triangles;
  return {{"min_angle_deg", triangles.min_angle_deg},
          {"shape_min", triangles.shape_min},
          {"shape_p1", triangles.shape_p1},
          {"shape_mean", triangles.shape_mean},
          {"mean_length_to_size", triangles.edges.mean_length_ratio},
          {"edges_in_band", triangles.edges.in_band},
          {"faces_below_20_deg", sharp_faces(report)}};
}

Json quality_json(const RunReport& report) {
  Json json = {{"min_dihedral_deg", nullptr},
               {"mean_ratio_min", nullptr},
               {"mean_ratio_p1", nullptr},
               {"mean_ratio_mean", nullptr},
               {"edges_in_band", nullptr}};
  if (!report.quality) return json;
  const TetQuality& tets = report.quality->tets;
  if (tets.count > 0) {
    json["min_dihedral_deg"] = tets.min_dihedral_deg;
    json["mean_ratio_min"] = tets.mean_ratio_min;
    json["mean_ratio_p1"] = tets.mean_ratio_p1;
    json["mean_ratio_mean"] = tets.mean_ratio_mean;
  }
  json["edges_in_band"] = tets.count > 0 ? tets.edges.in_band : report.quality->triangles.edges.in_band;
  if (const CurvedQuality& curved = report.quality->curved; curved.count > 0)
    json["second_order"] = {{"curved_cells", curved.count},
                            {"not_positive", curved.not_positive},
                            {"min_scaled_jacobian", curved.min_scaled_jacobian},
                            {"volume", curved.volume}};
  if (const CellQuality& cells = report.quality->cells; cells.count > tets.count)
    json["cells"] = {{"min_scaled_jacobian", cells.min_scaled_jacobian},
                     {"scaled_jacobian_p1", cells.scaled_jacobian_p1}};
  if (report.quality->triangles.count > 0) json["surface"] = surface_quality_json(report);
  return json;
}

Json volume_json(const RunReport& report) {
  Json json = {{"mesh", nullptr}, {"model", nullptr}};
  if (report.quality && report.quality->cells.count > 0) json["mesh"] = report.quality->cells.volume;
  if (report.model_volume) json["model"] = *report.model_volume;
  return json;
}

Json seconds_json(const RunReport& report) {
  const RunSeconds& seconds = report.seconds;
  return {{"total", report.total_seconds()},      {"read", seconds.read},     {"size_field", seconds.size_field},
          {"surface", seconds.surface},           {"layers", seconds.layers}, {"volume", seconds.volume},
          {"second_order", seconds.second_order}, {"check", seconds.check},   {"write", seconds.write}};
}

// Other kinds of elements where there are any.
Json counts_json(const RunReport& report) {
  const RunCounts& counts = report.counts;
  Json json = {
      {"points", counts.points}, {"triangles", counts.triangles}, {"tets", counts.tets}, {"regions", counts.regions}};
  if (!report.quality || report.quality->cells.count == report.quality->tets.count) return json;
  for (const auto& [name, kind] :
       {std::pair{"pyramids", CellKind::Pyramid}, {"prisms", CellKind::Prism}, {"hexahedra", CellKind::Hex}})
    json[name] = report.quality->cells.counts[static_cast<std::size_t>(kind)];
  return json;
}

}  // namespace

Json point_json(const std::optional<Vec3>& point) { return point ? Json{point->x, point->y, point->z} : Json(nullptr); }

double RunReport::total_seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void add_failure(RunReport& report, const Diagnostic& error) {
  report.errors.push_back(error);
  if (report.status == ExitStatus::Done) report.status = exit_status(error.code);
}

std::uint64_t peak_bytes() {
  std::uint64_t kibibytes = 0;
  for (const auto who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    if (::getrusage(who, &usage) == 0) kibibytes += static_cast<std::uint64_t>(usage.ru_maxrss);
  }
  return 1024 * kibibytes;
}

nlohmann::ordered_json to_json(const Diagnostic& diagnostic) {
  Json json = {{"code", to_string(diagnostic.code)},
               {"message", diagnostic.message},
               {"entities", entities_json(diagnostic.entities)},
               {"point", point_json(diagnostic.point)}};
  if (!diagnostic.elements.empty()) json["elements"] = diagnostic.elements;
  return json;
}

nlohmann::ordered_json acute_tets_json(const tets::OptimizeReport& optimizer) {
  Json worst = Json::array();
  for (const AcuteTet& tet : optimizer.acute_tets) worst.push_back(acute_tet_json(tet));
  return {{"count", optimizer.below_dihedral},
          {"forced_by_angles", optimizer.forced_by_angles},
          {"forced_by_triangles", optimizer.forced_by_triangles},
          {"forced_by_points", optimizer.forced_by_points},
          {"not_forced", optimizer.below_dihedral - optimizer.forced},
          {"worst", std::move(worst)}};
}

std::string to_json(const RunReport& report) {
  Json json = {{"schema", 1},
               {"status", report_status(report.status)},
               {"input", report.input},
               {"threads", report.threads},
               {"parts", report.parts},
               {"counts", counts_json(report)},
               {"seconds", seconds_json(report)},
               {"peak_bytes", peak_bytes()},
               {"quality", quality_json(report)},
               {"volume", volume_json(report)},
               {"digest", report.digest.empty() ? Json(nullptr) : Json(report.digest)},
               {"errors", diagnostics_json(report.errors)},
               {"warnings", diagnostics_json(report.warnings)}};
  json.update(report.extra);
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

void write_report(const RunReport& report, const std::filesystem::path& path) {
  AtomicFile file(path);
  file.write(to_json(report));
  file.write("\n");
  file.commit();
}

}  // namespace tetloom::app

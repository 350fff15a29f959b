#include "apps/tetloom/mesh_text.hpp"

#include "apps/tetloom/console.hpp"
#include "apps/tetloom/quantities.hpp"
#include "apps/tetloom/text_table.hpp"

namespace tetloom::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostRows = 30;

Box3 bounding_box(const Mesh& mesh) {
  Box3 box;
  for (const Vec3& p : mesh.points) {
    if (is_finite(p)) box.add(p);
  }
  return box;
}

const EntityAttributes* attributes_of(const RunReport& report, std::size_t dim, std::uint32_t index) {
  return index < report.entities[dim].size() ? &report.entities[dim][index] : nullptr;
}

std::string name_of(const RunReport& report, std::size_t dim, std::uint32_t index) {
  const EntityAttributes* const attributes = attributes_of(report, dim, index);
  return attributes != nullptr ? attributes->name : "";
}

std::string color_of(const RunReport& report, std::size_t dim, std::uint32_t index) {
  const EntityAttributes* const attributes = attributes_of(report, dim, index);
  return attributes != nullptr ? format_color(attributes->color) : "";
}

std::string tag_text(std::uint32_t index) { return index == ModelFaceId::kNone ? "none" : std::to_string(index + 1); }

Json tag_json(std::uint32_t index) { return index == ModelFaceId::kNone ? Json(nullptr) : Json(index + 1); }

std::string region_table(const RunReport& report) {
  const std::vector<RegionQuality>& regions = report.quality->cells.regions;
  if (regions.empty()) return {};
  std::vector<std::vector<std::string>> rows;
  for (const RegionQuality& region : regions) {
    rows.push_back({tag_text(region.region), name_of(report, 3, region.region), color_of(report, 3, region.region),
                    format_count(region.tets), format_number(region.volume)});
  }
  return render_table({"region", "name", "colour", "tets", "volume"}, rows, kMostRows);
}

std::string face_table(const RunReport& report) {
  const std::vector<FaceQuality>& faces = report.quality->triangles.faces;
  if (faces.empty()) return {};
  std::vector<std::vector<std::string>> rows;
  for (const FaceQuality& face : faces) {
    rows.push_back({tag_text(face.face), name_of(report, 2, face.face), color_of(report, 2, face.face),
                    format_count(face.triangles), format_number(face.area), format_number(face.min_angle_deg)});
  }
  return render_table({"face", "name", "colour", "triangles", "area", "smallest angle"}, rows, kMostRows);
}

}  // namespace

std::string render_mesh(const Mesh& mesh, const RunReport& report) {
  std::string text = report.input + ": " + format_count(mesh.points.size()) + " points, " +
                     format_count(mesh.edge_to_vert.size()) + " edges, " + format_count(mesh.tri_to_vert.size()) +
                     " triangles, " + format_count(mesh.tet_to_vert.size()) + " tets\n";
  text += "  box        " + format_box(bounding_box(mesh)) + "\n";
  if (!report.quality) return text;
  return text + render_quality(report) + region_table(report) + face_table(report);
}

nlohmann::ordered_json mesh_json(const Mesh& mesh, const RunReport& report) {
  const Box3 box = bounding_box(mesh);
  Json json = {{"edges", mesh.edge_to_vert.size()}, {"regions", Json::array()}, {"faces", Json::array()}};
  if (!box.empty()) json["bounding_box"] = {{box.lo.x, box.lo.y, box.lo.z}, {box.hi.x, box.hi.y, box.hi.z}};
  if (!report.quality) return json;
  for (const RegionQuality& region : report.quality->cells.regions) {
    json["regions"].push_back({{"id", tag_json(region.region)},
                               {"name", name_of(report, 3, region.region)},
                               {"tets", region.tets},
                               {"volume", region.volume}});
  }
  for (const FaceQuality& face : report.quality->triangles.faces) {
    json["faces"].push_back({{"id", tag_json(face.face)},
                             {"name", name_of(report, 2, face.face)},
                             {"triangles", face.triangles},
                             {"area", face.area},
                             {"min_angle_deg", face.min_angle_deg}});
  }
  return json;
}

}  // namespace tetloom::app

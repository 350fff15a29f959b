#include "apps/tetloom/mesh_text.hpp"

#include <array>
#include <utility>

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
                    format_count(region.cells), format_number(region.volume)});
  }
  return render_table({"region", "name", "colour", "cells", "volume"}, rows, kMostRows);
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

using NamedCount = std::pair<const char*, std::size_t>;

/// Elements beside edges, triangles and tets.
std::array<NamedCount, 4> other_elements(const Mesh& mesh) {
  return {NamedCount{"quadrilaterals", mesh.quad_to_vert.size()},
          {"pyramids", mesh.pyramid_to_vert.size()},
          {"prisms", mesh.prism_to_vert.size()},
          {"hexahedra", mesh.hex_to_vert.size()}};
}

std::string other_counts(const Mesh& mesh) {
  std::string text;
  for (const auto& [name, count] : other_elements(mesh))
    if (count > 0) text += ", " + format_count(count) + " " + name;
  return text;
}

std::string field_rows(const char* carriers, const std::vector<MeshField>& fields) {
  std::string text;
  for (const MeshField& field : fields)
    text += "  field      " + field.name + " on " + carriers +
            (field.components == 1 ? "" : ", " + std::to_string(field.components) + " components") + "\n";
  return text;
}

Json fields_json(const std::vector<MeshField>& fields) {
  Json json = Json::array();
  for (const MeshField& field : fields) json.push_back({{"name", field.name}, {"components", field.components}});
  return json;
}

}  // namespace

std::string render_mesh(const Mesh& mesh, const RunReport& report) {
  std::string text = report.input + ": " + format_count(mesh.points.size()) + " points, " +
                     format_count(mesh.edge_to_vert.size()) + " edges, " + format_count(mesh.tri_to_vert.size()) +
                     " triangles, " + format_count(mesh.tet_to_vert.size()) + " tets" + other_counts(mesh) + "\n";
  text += "  box        " + format_box(bounding_box(mesh)) + "\n";
  text += field_rows("points", mesh.point_fields) + field_rows("cells", mesh.cell_fields);
  if (!report.quality) return text;
  return text + render_quality(report) + region_table(report) + face_table(report);
}

nlohmann::ordered_json mesh_json(const Mesh& mesh, const RunReport& report) {
  const Box3 box = bounding_box(mesh);
  Json json = {{"edges", mesh.edge_to_vert.size()}, {"regions", Json::array()}, {"faces", Json::array()}};
  for (const auto& [name, count] : other_elements(mesh)) json[name] = count;
  json["point_fields"] = fields_json(mesh.point_fields);
  json["cell_fields"] = fields_json(mesh.cell_fields);
  if (!box.empty()) json["bounding_box"] = {{box.lo.x, box.lo.y, box.lo.z}, {box.hi.x, box.hi.y, box.hi.z}};
  if (!report.quality) return json;
  for (const RegionQuality& region : report.quality->cells.regions) {
    json["regions"].push_back({{"id", tag_json(region.region)},
                               {"name", name_of(report, 3, region.region)},
                               {"tets", region.tets},
                               {"cells", region.cells},
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

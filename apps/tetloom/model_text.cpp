#include "apps/tetloom/model_text.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "apps/tetloom/quantities.hpp"
#include "apps/tetloom/text_table.hpp"

namespace tetloom::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostEntityRows = 60;

std::string unit_text(double metres) {
  static constexpr std::array<std::pair<double, const char*>, 8> units{{{1e-6, "1 µm"},
                                                                        {1e-3, "1 mm"},
                                                                        {1e-2, "1 cm"},
                                                                        {1, "1 m"},
                                                                        {1e3, "1 km"},
                                                                        {0.0254, "1 inch"},
                                                                        {0.3048, "1 foot"},
                                                                        {2.54e-5, "1 mil"}}};
  if (!(metres > 0)) return "unknown";
  for (const auto& [value, text] : units) {
    if (std::abs(metres - value) <= 1e-6 * value) return text;
  }
  return format_number(metres) + " m";
}

std::string tags_of(const FaceSides& sides) {
  std::string text;
  for (const ModelRegionId side : {sides.back, sides.front}) {
    if (!side.valid()) continue;
    if (!text.empty() && sides.front == sides.back) return text + " (both sides)";
    text += (text.empty() ? "" : ", ") + std::to_string(side.tag());
  }
  return text;
}

std::string count_text(std::size_t count, const char* one, const char* many) {
  return format_count(count) + " " + (count == 1 ? one : many);
}

std::string region_table(const GeometricModel& model) {
  const ModelTopology& topology = model.topology();
  std::vector<std::vector<std::string>> rows;
  for (std::size_t r = 0; r < topology.region_count(); ++r) {
    const ModelRegionId id(r);
    const EntityAttributes& attributes = model.attributes(id);
    rows.push_back({std::to_string(id.tag()), attributes.name, format_color(attributes.color), attributes.layer,
                    format_number(model.volume(id)), format_count(topology.region_to_faces[r].size())});
  }
  return rows.empty() ? ""
                      : render_table({"region", "name", "colour", "layer", "volume", "faces"}, rows, kMostEntityRows);
}

std::string face_table(const GeometricModel& model) {
  const ModelTopology& topology = model.topology();
  std::vector<std::vector<std::string>> rows;
  for (std::size_t f = 0; f < topology.face_count(); ++f) {
    const ModelFaceId id(f);
    const EntityAttributes& attributes = model.attributes(id);
    rows.push_back({std::to_string(id.tag()), attributes.name, format_color(attributes.color), attributes.layer,
                    format_number(model.area(id)), tags_of(topology.face_to_sides[f])});
  }
  return rows.empty() ? "" : render_table({"face", "name", "colour", "layer", "area", "region"}, rows, kMostEntityRows);
}

/// Edges and vertices matter here only where the file has a name for them.
std::string named_table(const GeometricModel& model, int dim, const char* heading) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < model.topology().count(dim); ++i) {
    const ModelEntity entity(dim, static_cast<std::uint32_t>(i));
    const EntityAttributes& attributes = model.attributes(entity);
    if (attributes.name.empty()) continue;
    rows.push_back({std::to_string(entity.tag()), attributes.name, format_color(attributes.color), attributes.layer});
  }
  return rows.empty() ? "" : render_table({heading, "name", "colour", "layer"}, rows, kMostEntityRows);
}

Json attributes_json(const GeometricModel& model, ModelEntity entity) {
  const EntityAttributes& attributes = model.attributes(entity);
  Json json = {{"id", entity.tag()}, {"name", attributes.name}, {"color", nullptr}, {"layer", attributes.layer}};
  if (attributes.color) json["color"] = format_color(attributes.color);
  return json;
}

Json tag_or_null(ModelRegionId id) { return id.valid() ? Json(id.tag()) : Json(nullptr); }

Json regions_json(const GeometricModel& model) {
  Json list = Json::array();
  for (std::size_t r = 0; r < model.topology().region_count(); ++r) {
    Json json = attributes_json(model, ModelRegionId(r));
    json["volume"] = model.volume(ModelRegionId(r));
    json["faces"] = Json::array();
    for (const ModelFaceId face : model.topology().region_to_faces[r]) json["faces"].push_back(face.tag());
    list.push_back(std::move(json));
  }
  return list;
}

Json faces_json(const GeometricModel& model) {
  Json list = Json::array();
  for (std::size_t f = 0; f < model.topology().face_count(); ++f) {
    Json json = attributes_json(model, ModelFaceId(f));
    json["area"] = model.area(ModelFaceId(f));
    json["front"] = tag_or_null(model.topology().face_to_sides[f].front);
    json["back"] = tag_or_null(model.topology().face_to_sides[f].back);
    list.push_back(std::move(json));
  }
  return list;
}

}  // namespace

std::string render_model(const ModelDocument& document, const std::string& path) {
  const GeometricModel& model = *document.model;
  const ModelTopology& topology = model.topology();
  std::string text = path + ": " + document.format + ", length unit " + unit_text(model.metres_per_unit()) + "\n";
  text += "  box        " + format_box(model.bounding_box()) + "\n";
  text += "  entities   " + count_text(topology.region_count(), "region", "regions") + ", " +
          count_text(topology.face_count(), "face", "faces") + ", " +
          count_text(topology.edge_count(), "edge", "edges") + ", " +
          count_text(topology.vertex_count, "vertex", "vertices") + "\n";
  double area = 0, volume = 0;
  for (std::size_t f = 0; f < topology.face_count(); ++f) area += model.area(ModelFaceId(f));
  for (std::size_t r = 0; r < topology.region_count(); ++r) volume += model.volume(ModelRegionId(r));
  text += "  area       " + format_number(area) + "\n";
  if (topology.region_count() > 0) text += "  volume     " + format_number(volume) + "\n";
  for (const HealingStep& step : document.healing) {
    text += "  healed     " + step.what + (step.count > 1 ? " (" + format_count(step.count) + ")" : "") + "\n";
  }
  return text + region_table(model) + face_table(model) + named_table(model, 1, "edge") +
         named_table(model, 0, "vertex");
}

nlohmann::ordered_json model_json(const ModelDocument& document) {
  const GeometricModel& model = *document.model;
  const ModelTopology& topology = model.topology();
  const Box3& box = model.bounding_box();
  Json healing = Json::array();
  for (const HealingStep& step : document.healing) healing.push_back({{"what", step.what}, {"count", step.count}});
  return {{"format", document.format},
          {"metres_per_unit", model.metres_per_unit()},
          {"bounding_box", {{box.lo.x, box.lo.y, box.lo.z}, {box.hi.x, box.hi.y, box.hi.z}}},
          {"counts",
           {{"vertices", topology.vertex_count},
            {"edges", topology.edge_count()},
            {"faces", topology.face_count()},
            {"regions", topology.region_count()}}},
          {"healing", std::move(healing)},
          {"regions", regions_json(model)},
          {"faces", faces_json(model)}};
}

}  // namespace tetloom::app

#include "core/geometry/model_codec.hpp"

#include <span>

#include "core/base/codec.hpp"

namespace tetloom {
namespace {

template <class T>
void put_list(MessageWriter& writer, const std::vector<T>& list) {
  writer.put_array(std::span<const T>(list));
}

template <class T>
void put_lists(MessageWriter& writer, const std::vector<std::vector<T>>& lists) {
  writer.put(static_cast<std::uint64_t>(lists.size()));
  for (const std::vector<T>& list : lists) put_list(writer, list);
}

template <class T>
std::vector<std::vector<T>> get_lists(MessageReader& reader) {
  std::vector<std::vector<T>> lists;
  for (auto left = reader.get<std::uint64_t>(); left > 0; --left) lists.push_back(reader.get_array<T>());
  return lists;
}

}  // namespace

void put_topology(MessageWriter& writer, const ModelTopology& topology) {
  writer.put(static_cast<std::uint64_t>(topology.vertex_count));
  put_list(writer, topology.edges);
  writer.put(static_cast<std::uint64_t>(topology.face_to_loops.size()));
  for (const std::vector<ModelLoop>& loops : topology.face_to_loops) put_lists(writer, loops);
  put_list(writer, topology.face_to_sides);
  put_lists(writer, topology.region_to_faces);
}

ModelTopology get_topology(MessageReader& reader) {
  ModelTopology topology;
  topology.vertex_count = reader.get<std::uint64_t>();
  topology.edges = reader.get_array<ModelEdgeTopology>();
  for (auto left = reader.get<std::uint64_t>(); left > 0; --left)
    topology.face_to_loops.push_back(get_lists<EdgeUse>(reader));
  topology.face_to_sides = reader.get_array<FaceSides>();
  topology.region_to_faces = get_lists<ModelFaceId>(reader);
  return topology;
}

void put_attributes(MessageWriter& writer, const EntityAttributes& attributes) {
  put_text(writer, attributes.name);
  writer.put(attributes.color.has_value());
  writer.put(attributes.color.value_or(Color{}));
  put_text(writer, attributes.layer);
  writer.put(attributes.tolerance);
  put_text(writer, attributes.group);
}

EntityAttributes get_attributes(MessageReader& reader) {
  EntityAttributes attributes;
  attributes.name = get_text(reader);
  const bool has_color = reader.get<bool>();
  const Color color = reader.get<Color>();
  if (has_color) attributes.color = color;
  attributes.layer = get_text(reader);
  attributes.tolerance = reader.get<double>();
  attributes.group = get_text(reader);
  return attributes;
}

}  // namespace tetloom

#include "core/cad/detail/stored_cad_model.hpp"

#include <algorithm>
#include <functional>
#include <span>
#include <TopoDS.hxx>
#include <unordered_map>
#include <utility>

#include "core/cad/detail/cad_edge.hpp"
#include "core/cad/detail/occt_guard.hpp"
#include "tetloom/assert.hpp"

namespace tetloom::cad {
namespace {

/// The edges or faces of a model: the first of each shape, and which shape each one is.
struct DistinctShapes {
  std::vector<std::uint32_t> first;          ///< per shape
  std::vector<std::uint64_t> item_to_shape;  ///< numbered from 0
};

/// `is_alone` tells of an item whether it has a shape of its own whatever the others have.
template <class IsAlone>
DistinctShapes find_distinct(const TopTools_IndexedMapOfShape& items, const IsAlone& is_alone) {
  DistinctShapes result;
  std::unordered_map<const TopoDS_TShape*, std::uint64_t> known;
  for (int i = 1; i <= items.Extent(); ++i) {
    const auto [place, is_new] = known.emplace(items(i).TShape().get(), result.first.size());
    if (!is_new && is_alone(items(i))) place->second = result.first.size();
    if (place->second == result.first.size()) result.first.push_back(static_cast<std::uint32_t>(i - 1));
    result.item_to_shape.push_back(place->second);
  }
  return result;
}

using Encode = std::function<Bytes(std::uint32_t item)>;

/// Some hundred at a time, so that the bytes of a large model are never held at once.
void add_shapes(const std::vector<std::uint32_t>& items, const Encode& encode, const BlockLoop& loop,
                ShapeFileWriter& file) {
  constexpr std::size_t kTogether = 512, kGrain = 8;
  for (std::size_t begin = 0; begin < items.size(); begin += kTogether) {
    std::vector<Bytes> shapes(std::min(kTogether, items.size() - begin));
    loop.for_blocks(shapes.size(), kGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) shapes[i] = encode(items[begin + i]);
    });
    for (const Bytes& shape : shapes) file.add(shape);
  }
}

void put_placed(MessageWriter& writer, std::uint64_t shape, const TopLoc_Location& place) {
  writer.put(shape);
  writer.put_array(std::span<const LocationFactor>(factors_of(place)));
}

}  // namespace

void store_shapes(const CadModel& model, const BlockLoop& loop, ShapeFileWriter& file, MessageWriter& skeleton) {
  const ModelTopology& topology = model.topology();
  const ShapeTables& shapes = model.shapes();
  const auto is_alone = [](const TopoDS_Shape& edge) { return has_placed_curve(TopoDS::Edge(edge)); };
  const DistinctShapes edges = find_distinct(shapes.edges, is_alone);
  const DistinctShapes faces = find_distinct(shapes.faces, [](const TopoDS_Shape&) { return false; });
  const auto encode_one_edge = [&](std::uint32_t e) {
    return topology.edges[e].degenerate ? Bytes() : encode_edge(shapes.edge(ModelEdgeId(e)));
  };
  const auto encode_one_face = [&](std::uint32_t f) {
    return encode_face(face_shape(shapes, topology, ModelFaceId(f)), edges_of(topology, ModelFaceId(f)));
  };
  add_shapes(edges.first, encode_one_edge, loop, file);
  add_shapes(faces.first, encode_one_face, loop, file);

  StoredModel::put_frame(model, loop, skeleton);
  std::vector<int> places(faces.first.size());
  for (const std::uint64_t shape : faces.item_to_shape) ++places[shape];
  for (std::size_t e = 0; e < topology.edge_count(); ++e) {
    const TopoDS_Edge edge = shapes.edge(ModelEdgeId(e));
    put_placed(skeleton, edges.item_to_shape[e], is_alone(edge) ? TopLoc_Location() : edge.Location());
  }
  for (std::size_t f = 0; f < topology.face_count(); ++f) {
    const std::uint64_t shape = faces.item_to_shape[f];
    put_placed(skeleton, edges.first.size() + shape, shapes.face(ModelFaceId(f)).Location());
    skeleton.put(static_cast<std::uint8_t>(places[shape] > 1));
    skeleton.put(model.place(ModelFaceId(f)));
  }
}

StoredCadModel::StoredCadModel(std::shared_ptr<const ShapeFile> file, MessageReader& skeleton, std::uint64_t most_bytes)
    : StoredModel(std::move(file), skeleton, most_bytes) {
  const auto get_placed = [](MessageReader& reader) {
    const auto shape = reader.get<std::uint64_t>();
    return Placed{shape, reader.get_array<LocationFactor>()};
  };
  for (std::size_t e = 0; e < topology_.edge_count(); ++e) edges_.push_back(get_placed(skeleton));
  for (std::size_t f = 0; f < topology_.face_count(); ++f) {
    faces_.push_back(get_placed(skeleton));
    is_repeated_.push_back(skeleton.get<std::uint8_t>());
    places_.push_back(skeleton.get<FacePlace>());
  }
}

std::unique_ptr<EdgeGeometry> StoredCadModel::edge_geometry(ModelEdgeId id) const {
  TETLOOM_ASSERT(id.value < edges_.size());
  const NamedEntity who = named(id);
  const auto edge = held().get<TopoDS_Edge>(id.value, [&] {
    return translate_failures(who, ErrorCode::EdgeFailed, "reading its shape", [&] {
      const Bytes bytes = file().read(edges_[id.value].shape);
      auto decoded = std::make_shared<const TopoDS_Edge>(decode_edge(bytes, edges_[id.value].place));
      return HeldShapes::Shape{std::move(decoded), bytes.size()};
    });
  });
  return std::make_unique<CadEdge>(*edge, who);
}

std::unique_ptr<FaceGeometry> StoredCadModel::face_geometry(ModelFaceId id) const {
  TETLOOM_ASSERT(id.value < faces_.size());
  const NamedEntity who = named(id);
  const auto face = held().get<CadFace>(edges_.size() + id.value, [&] {
    return translate_failures(who, ErrorCode::FaceFailed, "reading its shape", [&] {
      const Placed& placed = faces_[id.value];
      const Bytes bytes = file().read(placed.shape);
      auto shape = std::make_shared<const FaceShape>(
          decode_face(bytes, edges_of(topology_, id), placed.place, is_repeated_[id.value] != 0));
      return HeldShapes::Shape{std::make_shared<const CadFace>(std::move(shape), topology_, id, who), bytes.size()};
    });
  });
  return face->another();
}

FacePlace StoredCadModel::place(ModelFaceId id) const {
  TETLOOM_ASSERT(id.value < places_.size());
  return places_[id.value];
}

std::uint64_t StoredCadModel::shape_bytes(ModelEntity entity) const {
  if (entity.dim != 1 && entity.dim != 2) return 0;
  const std::vector<Placed>& placed = entity.dim == 1 ? edges_ : faces_;
  TETLOOM_ASSERT(entity.index < placed.size());
  return file().bytes_of(placed[entity.index].shape);
}

}  // namespace tetloom::cad

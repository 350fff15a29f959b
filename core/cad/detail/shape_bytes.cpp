#include "core/cad/detail/shape_bytes.hpp"

#include <BinTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_CurveRepresentation.hxx>
#include <BRep_ListOfCurveRepresentation.hxx>
#include <BRep_TEdge.hxx>
#include <BRep_TFace.hxx>
#include <BRep_Tool.hxx>
#include <BRep_TVertex.hxx>
#include <Geom_Curve.hxx>
#include <istream>
#include <memory>
#include <sstream>
#include <streambuf>
#include <string>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <vector>

#include "core/cad/detail/exact_frames.hpp"
#include "tetloom/error.hpp"

namespace tetloom::cad {
namespace {

/// Reads from bytes where they lie.
class BytesBuffer : public std::streambuf {
 public:
  explicit BytesBuffer(std::span<const char> bytes) {
    char* begin = const_cast<char*>(bytes.data());  // a streambuf never writes to what it only gets from
    setg(begin, begin, begin + bytes.size());
  }

 protected:
  pos_type seekoff(off_type offset, std::ios_base::seekdir direction, std::ios_base::openmode) override {
    char* const from = direction == std::ios_base::beg ? eback() : direction == std::ios_base::cur ? gptr() : egptr();
    if (from + offset < eback() || from + offset > egptr()) return pos_type(off_type(-1));
    setg(eback(), from + offset, egptr());
    return gptr() - eback();
  }
  pos_type seekpos(pos_type position, std::ios_base::openmode mode) override {
    return seekoff(off_type(position), std::ios_base::beg, mode);
  }
};

Bytes to_bytes(const TopoDS_Shape& shape, const std::vector<std::uint32_t>& numbers) {
  std::ostringstream stream;
  BinTools::Write(shape, stream, false, false, BinTools_FormatVersion_CURRENT);
  const std::string text = std::move(stream).str();
  MessageWriter writer;
  writer.put_array(std::span<const std::uint32_t>(numbers));
  writer.put_array(std::span<const char>(text));
  writer.put_array(std::span<const double>(frames_of(shape)));
  put_locations(shape, writer);
  return writer.take();
}

struct Decoded {
  TopoDS_Shape shape;
  std::vector<std::uint32_t> numbers;
};

Decoded from_bytes(std::span<const std::byte> bytes, LocationMaker& maker) {
  MessageReader reader(bytes);
  Decoded decoded;
  decoded.numbers = reader.get_array<std::uint32_t>();
  BytesBuffer buffer(reader.get_view<char>());
  std::istream stream(&buffer);
  BinTools::Read(decoded.shape, stream);
  if (decoded.shape.IsNull() || !set_frames(decoded.shape, reader.get_array<double>()))
    throw Error(ErrorCode::Internal, "a stored shape could not be read back");
  decoded.shape = with_locations(decoded.shape, reader, maker);
  return decoded;
}

/// Leaves the curves in space and on the face, wherever on it.
void drop_other_curves(const TopoDS_Edge& edge, const Handle(Geom_Surface) & surface) {
  BRep_ListOfCurveRepresentation& curves = Handle(BRep_TEdge)::DownCast(edge.TShape())->ChangeCurves();
  for (BRep_ListOfCurveRepresentation::Iterator one(curves); one.More();) {
    const Handle(BRep_CurveRepresentation)& curve = one.Value();
    const bool is_kept = curve->IsCurve3D() || (curve->IsCurveOnSurface() && curve->Surface() == surface);
    is_kept ? one.Next() : curves.Remove(one);
  }
}

/// The face without its location, of parts of its own, without what these are elsewhere.
TopoDS_Shape apart(const TopoDS_Face& face) {
  const TopoDS_Shape copy = copy_of(face.Located({}));
  const Handle(Geom_Surface) surface = Handle(BRep_TFace)::DownCast(copy.TShape())->Surface();
  for (TopExp_Explorer edge(copy, TopAbs_EDGE); edge.More(); edge.Next())
    drop_other_curves(TopoDS::Edge(edge.Current()), surface);
  for (TopExp_Explorer vertex(copy, TopAbs_VERTEX); vertex.More(); vertex.Next())
    Handle(BRep_TVertex)::DownCast(vertex.Current().TShape())->ChangePoints().Clear();
  return copy;
}

TopTools_IndexedMapOfShape edges_in(const TopoDS_Face& face) {
  TopTools_IndexedMapOfShape edges;
  TopExp::MapShapes(face, TopAbs_EDGE, edges);
  return edges;
}

}  // namespace

Bytes encode_face(const FaceShape& shape, const std::vector<ModelEdgeId>& ids) {
  const TopTools_IndexedMapOfShape edges = edges_in(shape.face());
  std::vector<std::uint32_t> numbers;
  for (const ModelEdgeId id : ids) {
    const int number = edges.FindIndex(shape.edge(id));
    if (number == 0) throw Error(ErrorCode::Internal, "an edge of a face is not found in its shape");
    numbers.push_back(static_cast<std::uint32_t>(number));
  }
  return to_bytes(apart(shape.face()), numbers);
}

FaceShape decode_face(std::span<const std::byte> bytes, const std::vector<ModelEdgeId>& ids,
                      const LocationFactors& place, bool is_repeated) {
  LocationMaker maker;
  const Decoded decoded = from_bytes(bytes, maker);
  const TopoDS_Face bare = TopoDS::Face(decoded.shape);
  const TopoDS_Face face = TopoDS::Face(bare.Located(maker.make(place), false));
  const TopTools_IndexedMapOfShape all = edges_in(face);
  std::vector<TopoDS_Edge> edges;
  for (const std::uint32_t number : decoded.numbers) {
    if (number == 0 || number > static_cast<std::uint32_t>(all.Extent()))
      throw Error(ErrorCode::Internal, "a stored face has other edges");
    edges.push_back(TopoDS::Edge(all(static_cast<int>(number)).Oriented(TopAbs_FORWARD)));
  }
  std::shared_ptr<SharedFacets> facets;
  if (is_repeated) {
    facets = std::make_shared<SharedFacets>();
    facets->add_repeated(bare);
  }
  return {face, ids, edges, std::move(facets)};
}

bool has_placed_curve(const TopoDS_Edge& edge) {
  TopLoc_Location location;
  double first = 0, last = 0;
  BRep_Tool::Curve(TopoDS::Edge(edge.Located({})), location, first, last);
  return !location.IsIdentity();
}

Bytes encode_edge(const TopoDS_Edge& edge) {
  const bool is_placed = has_placed_curve(edge);
  double first = 0, last = 0;
  const Handle(Geom_Curve) curve = BRep_Tool::Curve(is_placed ? edge : TopoDS::Edge(edge.Located({})), first, last);
  if (curve.IsNull()) return {};  // whoever asks for it is told
  BRep_Builder builder;
  TopoDS_Edge bare;
  builder.MakeEdge(bare, curve, 0);
  builder.Range(bare, first, last);
  return to_bytes(bare, {});
}

TopoDS_Edge decode_edge(std::span<const std::byte> bytes, const LocationFactors& place) {
  if (bytes.empty()) throw Error(ErrorCode::EdgeFailed, "the edge has no curve in space");
  LocationMaker maker;
  return TopoDS::Edge(from_bytes(bytes, maker).shape.Located(maker.make(place), false));
}

}  // namespace tetloom::cad

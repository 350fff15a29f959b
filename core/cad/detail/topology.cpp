#include "core/cad/detail/topology.hpp"

#include <algorithm>
#include <BRep_Tool.hxx>
#include <BRepAdaptor_Surface.hxx>
#include <Geom2d_Curve.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Iterator.hxx>

#include "core/base/lists.hpp"
#include "core/cad/detail/conversions.hpp"
#include "core/cad/detail/loops.hpp"

namespace tetloom::cad {

TopoDS_Vertex ShapeTables::vertex(ModelVertexId id) const {
  return TopoDS::Vertex(vertices.FindKey(static_cast<int>(id.value) + 1));
}
TopoDS_Edge ShapeTables::edge(ModelEdgeId id) const {
  return TopoDS::Edge(edges.FindKey(static_cast<int>(id.value) + 1).Oriented(TopAbs_FORWARD));
}
TopoDS_Face ShapeTables::face(ModelFaceId id) const {
  return TopoDS::Face(faces.FindKey(static_cast<int>(id.value) + 1).Oriented(TopAbs_FORWARD));
}
TopoDS_Solid ShapeTables::solid(ModelRegionId id) const {
  return TopoDS::Solid(solids.FindKey(static_cast<int>(id.value) + 1));
}

namespace {

template <class Id>
Id id_of(const TopTools_IndexedMapOfShape& map, const TopoDS_Shape& shape) {
  const int index = map.FindIndex(shape);
  return index > 0 ? Id(static_cast<std::size_t>(index - 1)) : Id();
}

class TopologyBuilder {
 public:
  explicit TopologyBuilder(const TopoDS_Shape& root) : root_(root) {}

  ShapeTopology build() {
    TopExp::MapShapes(root_, TopAbs_FACE, out_.shapes.faces);
    number_solids();
    number_edges();
    number_vertices();
    warn_of_free_shapes(TopAbs_EDGE, out_.shapes.edges, "edges");
    warn_of_free_shapes(TopAbs_VERTEX, out_.shapes.vertices, "vertices");
    for (int i = 1; i <= out_.shapes.faces.Extent(); ++i) add_face(TopoDS::Face(out_.shapes.faces(i)));
    add_regions();
    return std::move(out_);
  }

 private:
  /// Calls visit(edge in its wire's orientation) for what bounds or splits the face, wire by wire.
  template <class Visit, class EndWire>
  static void for_each_use(const TopoDS_Face& face, const Visit& visit, const EndWire& end_wire) {
    for (TopoDS_Iterator wire(face.Oriented(TopAbs_FORWARD)); wire.More(); wire.Next()) {
      if (wire.Value().ShapeType() != TopAbs_WIRE) continue;
      for (TopoDS_Iterator edge(wire.Value()); edge.More(); edge.Next())
        if (edge.Value().Orientation() != TopAbs_EXTERNAL) visit(TopoDS::Edge(edge.Value()));
      end_wire();
    }
  }

  // A solid may be stored reversed, which turns its inside out; other orientations make no sense for it.
  static TopoDS_Shape with_sides(const TopoDS_Shape& solid) {
    return solid.Orientation() == TopAbs_REVERSED ? solid : solid.Oriented(TopAbs_FORWARD);
  }

  void number_solids() {
    TopTools_IndexedMapOfShape all;
    TopExp::MapShapes(root_, TopAbs_SOLID, all);
    for (int i = 1; i <= all.Extent(); ++i)
      if (TopExp_Explorer(all(i), TopAbs_FACE).More()) out_.shapes.solids.Add(with_sides(all(i)));
    const int empty = all.Extent() - out_.shapes.solids.Extent();
    if (empty > 0)
      out_.warnings.push_back(
          {ErrorCode::InputUnsuitable, std::to_string(empty) + " solids without any face were left out", {}, {}, {}});
  }

  void number_edges() {
    for (int i = 1; i <= out_.shapes.faces.Extent(); ++i)
      for_each_use(
          TopoDS::Face(out_.shapes.faces(i)), [&](const TopoDS_Edge& edge) { out_.shapes.edges.Add(edge); }, [] {});
  }

  void number_vertices() {
    for (int i = 1; i <= out_.shapes.edges.Extent(); ++i) {
      const TopoDS_Edge edge = TopoDS::Edge(out_.shapes.edges(i).Oriented(TopAbs_FORWARD));
      TopoDS_Vertex first, last;
      TopExp::Vertices(edge, first, last);
      if (first.IsNull() || last.IsNull()) throw_endless(static_cast<std::size_t>(i - 1));
      out_.shapes.vertices.Add(first);
      out_.shapes.vertices.Add(last);
      ModelEdgeTopology& entry = out_.topology.edges.emplace_back();
      entry.vertices = {id_of<ModelVertexId>(out_.shapes.vertices, first),
                        id_of<ModelVertexId>(out_.shapes.vertices, last)};
      entry.degenerate = BRep_Tool::Degenerated(edge);
    }
    out_.topology.vertex_count = static_cast<std::size_t>(out_.shapes.vertices.Extent());
  }

  [[noreturn]] static void throw_endless(std::size_t index) {
    Diagnostic diagnostic;
    diagnostic.code = ErrorCode::InputUnsuitable;
    diagnostic.message = "an edge has no end points (it is infinite or the file is damaged)";
    diagnostic.entities.push_back({ModelEdgeId(index), ""});
    throw Error(std::move(diagnostic));
  }

  void warn_of_free_shapes(TopAbs_ShapeEnum type, const TopTools_IndexedMapOfShape& used, const char* what) {
    TopTools_IndexedMapOfShape all;
    TopExp::MapShapes(root_, type, all);
    int free = 0;
    for (int i = 1; i <= all.Extent(); ++i) free += used.Contains(all(i)) ? 0 : 1;
    if (free == 0) return;
    out_.warnings.push_back({ErrorCode::InputUnsuitable,
                             std::to_string(free) + " " + what + " that bound no face were left out",
                             {},
                             {},
                             {}});
  }

  void add_face(const TopoDS_Face& face) {
    const ModelFaceId id(out_.topology.face_to_loops.size());
    std::vector<ModelLoop>& loops = out_.topology.face_to_loops.emplace_back();
    std::vector<LoopPiece> wire, leftover;
    const auto end_wire = [&] {
      ChainedLoops chained = chain_loops(wire);
      loops.insert(loops.end(), chained.loops.begin(), chained.loops.end());
      leftover.insert(leftover.end(), chained.open.begin(), chained.open.end());
      wire.clear();
    };
    const TopoDS_Face forward = TopoDS::Face(face.Oriented(TopAbs_FORWARD));
    const Vec2 scale = uv_scale(forward);
    for_each_use(
        forward, [&](const TopoDS_Edge& edge) { add_pieces(forward, edge, scale, wire); }, end_wire);
    if (!leftover.empty()) join_leftover(id, leftover, loops);
  }

  // Wires that do not close by themselves may close together.
  void join_leftover(ModelFaceId id, const std::vector<LoopPiece>& leftover, std::vector<ModelLoop>& loops) {
    ChainedLoops chained = chain_loops(leftover);
    loops.insert(loops.end(), chained.loops.begin(), chained.loops.end());
    if (chained.open.empty()) return;
    ModelLoop& loop = loops.emplace_back();
    for (const LoopPiece& piece : chained.open) loop.push_back(piece.use);
    const TopoDS_Vertex end = out_.shapes.vertex(chained.open.back().end);
    Diagnostic warning{ErrorCode::InputUnsuitable, "the boundary of a face does not close", {{id, ""}}, {}, {}};
    warning.entities.push_back({chained.open.back().use.edge, ""});
    warning.point = to_vec3(BRep_Tool::Pnt(end));
    out_.warnings.push_back(std::move(warning));
  }

  static Vec2 uv_scale(const TopoDS_Face& face) {
    Vec2 lo{HUGE_VAL, HUGE_VAL}, hi{-HUGE_VAL, -HUGE_VAL};
    for_each_use(
        face,
        [&](const TopoDS_Edge& edge) {
          double first, last;
          const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, face, first, last);
          if (curve.IsNull()) return;
          for (int i = 0; i <= 4; ++i) {
            const Vec2 p = to_vec2(curve->Value(first + (last - first) * i / 4));
            lo = {std::min(lo.u, p.u), std::min(lo.v, p.v)};
            hi = {std::max(hi.u, p.u), std::max(hi.v, p.v)};
          }
        },
        [] {});
    const auto inverse = [](double width) { return width > 0 && std::isfinite(width) ? 1 / width : 1.0; };
    return {inverse(hi.u - lo.u), inverse(hi.v - lo.v)};
  }

  void add_pieces(const TopoDS_Face& face, const TopoDS_Edge& edge, const Vec2& scale, std::vector<LoopPiece>& wire) {
    if (edge.Orientation() != TopAbs_INTERNAL) {
      wire.push_back(make_piece(face, edge, scale));
      return;
    }
    wire.push_back(make_piece(face, TopoDS::Edge(edge.Oriented(TopAbs_FORWARD)), scale));
    wire.push_back(make_piece(face, TopoDS::Edge(edge.Oriented(TopAbs_REVERSED)), scale));
  }

  LoopPiece make_piece(const TopoDS_Face& face, const TopoDS_Edge& edge, const Vec2& scale) const {
    LoopPiece piece;
    piece.use.edge = id_of<ModelEdgeId>(out_.shapes.edges, edge);
    piece.use.forward = edge.Orientation() == TopAbs_FORWARD;
    piece.use.second_side = !piece.use.forward && BRep_Tool::IsClosed(edge, face);
    const auto& vertices = out_.topology.edges[piece.use.edge.value].vertices;
    piece.start = vertices[piece.use.forward ? 0 : 1];
    piece.end = vertices[piece.use.forward ? 1 : 0];
    double first, last;
    const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, face, first, last);
    if (curve.IsNull()) return piece;
    if (!piece.use.forward) std::swap(first, last);
    const auto at = [&](double share) {
      const gp_Pnt2d p = curve->Value(first + (last - first) * share);
      return Vec2{p.X() * scale.u, p.Y() * scale.v};
    };
    constexpr double step = 0.01;  // a short chord: robust where the derivative vanishes
    piece.uv_start = at(0);
    piece.uv_end = at(1);
    piece.tangent_start = at(step) - piece.uv_start;
    piece.tangent_end = piece.uv_end - at(1 - step);
    return piece;
  }

  void add_regions() {
    out_.topology.face_to_sides.resize(out_.topology.face_count());
    for (int i = 1; i <= out_.shapes.solids.Extent(); ++i) add_region(i);
  }

  void add_region(int index) {
    const ModelRegionId region(static_cast<std::size_t>(index - 1));
    std::vector<ModelFaceId>& faces = out_.topology.region_to_faces.emplace_back();
    for (TopExp_Explorer face(out_.shapes.solids(index), TopAbs_FACE); face.More(); face.Next()) {
      const TopAbs_Orientation orientation = face.Current().Orientation();
      if (orientation == TopAbs_EXTERNAL) continue;
      const ModelFaceId id = id_of<ModelFaceId>(out_.shapes.faces, face.Current());
      FaceSides& sides = out_.topology.face_to_sides[id.value];
      if (orientation != TopAbs_FORWARD) claim(sides.front, region, id);
      if (orientation != TopAbs_REVERSED) claim(sides.back, region, id);
      faces.push_back(id);
    }
    sort_unique(faces);
  }

  void claim(ModelRegionId& side, ModelRegionId region, ModelFaceId face) {
    if (!side.valid()) {
      side = region;
      return;
    }
    Diagnostic warning{ErrorCode::InputUnsuitable, "two regions lie on the same side of a face", {}, {}, {}};
    warning.entities = {{face, ""}, {side, ""}, {region, ""}};
    out_.warnings.push_back(std::move(warning));
  }

  const TopoDS_Shape& root_;
  ShapeTopology out_;
};

}  // namespace

ShapeTopology make_topology(const TopoDS_Shape& root) { return TopologyBuilder(root).build(); }

}  // namespace tetloom::cad

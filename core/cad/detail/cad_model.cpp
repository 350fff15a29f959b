#include "core/cad/detail/cad_model.hpp"

#include <algorithm>
#include <Bnd_Box.hxx>
#include <BRep_Tool.hxx>
#include <BRepBndLib.hxx>
#include <cmath>
#include <gp_Trsf.hxx>
#include <map>
#include <optional>
#include <TopExp_Explorer.hxx>
#include <utility>
#include <vector>

#include "core/cad/detail/cad_edge.hpp"
#include "core/cad/detail/cad_face.hpp"
#include "core/cad/detail/conversions.hpp"
#include "core/cad/detail/occt_guard.hpp"
#include "tetloom/assert.hpp"

namespace tetloom::cad {
namespace {

Box3 to_box3(Bnd_Box box) {
  if (box.IsVoid()) return {};
  if (box.IsOpen()) throw Error(ErrorCode::InputUnsuitable, "the model is infinite");
  box.SetGap(0);
  Box3 result;
  result.add(to_vec3(box.CornerMin()));
  result.add(to_vec3(box.CornerMax()));
  return result;
}

bool covers(const Box3& outer, const Box3& inner) { return outer.contains(inner.lo) && outer.contains(inner.hi); }

/// How far `inner` sticks out of `outer`; 0 where that covers it.
double overhang(const Box3& outer, const Box3& inner) {
  double most = 0;
  for (int axis = 0; axis < 3; ++axis)
    most = std::max({most, outer.lo[axis] - inner.lo[axis], inner.hi[axis] - outer.hi[axis]});
  return most;
}

Box3 loose_box(const TopoDS_Face& face) {
  Bnd_Box box;
  BRepBndLib::Add(face, box, false);
  return to_box3(box);
}

Box3 tight_box(const TopoDS_Face& face) {
  Bnd_Box box;
  BRepBndLib::AddOptimal(face, box, false, false);
  return to_box3(box);
}

/// The tight box of a face costs an optimisation; most faces lie inside the box of the others anyway, the more so when
/// those that may stick out farthest come first.
Box3 compute_box(const ShapeTables& shapes, std::size_t face_count, const BlockLoop& loop) {
  Box3 result;
  for (int i = 1; i <= shapes.vertices.Extent(); ++i)
    result.add(to_vec3(BRep_Tool::Pnt(shapes.vertex(ModelVertexId(static_cast<std::size_t>(i - 1))))));
  constexpr std::size_t kBatch = 4;  // for threads; few, since one face may make the next ones needless
  std::vector<Box3> loose(face_count);
  std::vector<std::pair<double, std::size_t>> order;
  loop.for_blocks(face_count, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) loose[i] = loose_box(shapes.face(ModelFaceId(i)));
  });
  for (std::size_t i = 0; i < face_count; ++i) order.emplace_back(-overhang(result, loose[i]), i);
  std::sort(order.begin(), order.end());
  for (auto next = order.begin(); next != order.end();) {
    std::vector<std::size_t> batch;
    for (; next != order.end() && batch.size() < kBatch; ++next)
      if (!covers(result, loose[next->second])) batch.push_back(next->second);
    std::vector<Box3> tight(batch.size());
    loop.for_blocks(batch.size(), 1,
                    [&](std::size_t k, std::size_t) { tight[k] = tight_box(shapes.face(ModelFaceId(batch[k]))); });
    for (std::size_t k = 0; k < batch.size(); ++k)
      if (!covers(result, loose[batch[k]])) result.add(tight[k]);
  }
  if (result.empty()) throw Error(ErrorCode::InputUnsuitable, "the model has no extent");
  return result;
}

/// Per face, the first one of the same shape, wherever it stands.
std::vector<std::uint32_t> number_shapes(const TopTools_IndexedMapOfShape& faces) {
  std::map<const TopoDS_TShape*, std::uint32_t> first;
  std::vector<std::uint32_t> numbers;
  for (int i = 1; i <= faces.Extent(); ++i) {
    const auto number = static_cast<std::uint32_t>(numbers.size());
    numbers.push_back(first.emplace(faces(i).TShape().get(), number).first->second);
  }
  return numbers;
}

/// None where `placing` mirrors or scales.
std::optional<RigidMotion> to_motion(const gp_Trsf& placing) {
  constexpr double kUnit = 1e-12;
  if (placing.IsNegative() || std::abs(placing.ScaleFactor() - 1) > kUnit) return std::nullopt;
  const gp_Mat& turn = placing.HVectorialPart();
  return RigidMotion{{to_vec3(turn.Column(1)), to_vec3(turn.Column(2)), to_vec3(turn.Column(3))},
                     to_vec3(placing.TranslationPart())};
}

/// Places at which a parameter curve is compared with its edge, and what is added for the places between.
constexpr int kToleranceSamples = 40;
constexpr double kToleranceMargin = 1.25;

}  // namespace

CadModel::CadModel(ShapeTopology parts, Document document, const BlockLoop& loop)
    : document_(std::move(document)),
      shapes_(std::move(parts.shapes)),
      faces_(parts.topology.face_count()),
      integrals_(parts.topology.face_count()),
      volumes_(parts.topology.region_count()) {
  document_.facets->add_places(shapes_.faces);
  shapes_.facets = document_.facets;
  face_to_shape_ = number_shapes(shapes_.faces);
  topology_ = std::move(parts.topology);
  attributes_ = make_entity_attributes(document_.root, document_.attributes, shapes_);
  metres_per_unit_ = document_.metres_per_unit;
  translate_failures({}, ErrorCode::InputUnsuitable, "the bounding box",
                     [&] { bounding_box_ = compute_box(shapes_, topology_.face_count(), loop); });
  measure_tolerances(loop);
}

// Files understate how far parameter curves lie off their edges, and vertices off both.
void CadModel::measure_tolerances(const BlockLoop& loop) {
  std::vector<std::vector<Gap>> gaps(topology_.face_count());
  loop.for_blocks(gaps.size(), 1, [&](std::size_t i, std::size_t) { gaps[i] = measure_face(ModelFaceId(i)); });
  for (const std::vector<Gap>& of_face : gaps)
    for (const Gap& gap : of_face) {
      double& tolerance = attributes_[gap.entity.dim][gap.entity.index].tolerance;
      if (gap.width > tolerance) tolerance = kToleranceMargin * gap.width;
    }
}

/// The gaps wider than the file says, in the order in which they are met.
std::vector<CadModel::Gap> CadModel::measure_face(ModelFaceId id) const {
  std::vector<Gap> gaps;
  try {
    const auto face = face_geometry(id);
    for (const ModelLoop& loop : topology_.face_to_loops[id.value]) {
      for (const EdgeUse& use : loop) {
        if (topology_.edges[use.edge.value].degenerate) continue;
        const auto edge = edge_geometry(use.edge);
        measure_use(*face, *edge, use, gaps);
      }
    }
  } catch (const Error& error) {  // whoever meshes this face gets the same error, with its place
    if (error.code() == ErrorCode::OutOfMemory) throw;
  }
  return gaps;
}

void CadModel::measure_use(FaceGeometry& face, EdgeGeometry& edge, const EdgeUse& use, std::vector<Gap>& gaps) const {
  const auto note = [&](ModelEntity entity, double gap) {
    if (gap > attributes_[entity.dim][entity.index].tolerance) gaps.push_back({entity, gap});
  };
  const ParameterRange range = face.edge_range(use);
  for (int i = 0; i <= kToleranceSamples; ++i) {
    const double t = range.lo + (range.hi - range.lo) * i / kToleranceSamples;
    const Vec3 on_edge = edge.evaluate(t), on_face = face.evaluate(face.edge_parameters(use, t));
    note(use.edge, distance(on_edge, on_face));
    if (i > 0 && i < kToleranceSamples) continue;
    const ModelVertexId vertex = topology_.edges[use.edge.value].vertices[i == 0 ? 0 : 1];
    const Vec3 at = vertex_point(vertex);
    note(vertex, std::max(distance(at, on_edge), distance(at, on_face)));
  }
}

Vec3 CadModel::vertex_point(ModelVertexId id) const {
  TETLOOM_ASSERT(id.value < topology_.vertex_count);
  return to_vec3(BRep_Tool::Pnt(shapes_.vertex(id)));
}

std::unique_ptr<EdgeGeometry> CadModel::edge_geometry(ModelEdgeId id) const {
  TETLOOM_ASSERT(id.value < topology_.edge_count());
  return std::make_unique<CadEdge>(shapes_.edge(id), named(id));
}

std::unique_ptr<FaceGeometry> CadModel::face_geometry(ModelFaceId id) const {
  TETLOOM_ASSERT(id.value < topology_.face_count());
  const auto& known = faces_.get(id.value, [&] {
    auto shape = std::make_shared<const FaceShape>(face_shape(shapes_, topology_, id));
    return std::make_unique<const CadFace>(std::move(shape), topology_, id, named(id));
  });
  return known->another();
}

const FaceIntegrals& CadModel::integrals(ModelFaceId id) const {
  return integrals_.get(id.value, [&] {
    const TopoDS_Face face = shapes_.face(id);
    const auto known = find_integrals(document_.integrals, face);
    return known ? *known : integrate_face(face);
  });
}

double CadModel::area(ModelFaceId id) const {
  TETLOOM_ASSERT(id.value < topology_.face_count());
  return translate_failures(named(id), ErrorCode::FaceFailed, "the area", [&] { return integrals(id).area; });
}

FacePlace CadModel::place(ModelFaceId id) const {
  TETLOOM_ASSERT(id.value < face_to_shape_.size());
  const auto motion = to_motion(shapes_.face(id).Location().Transformation());
  return motion ? FacePlace{face_to_shape_[id.value], *motion} : FacePlace{};
}

double CadModel::volume(ModelRegionId id) const {
  TETLOOM_ASSERT(id.value < topology_.region_count());
  return translate_failures(named(id), ErrorCode::VolumeFailed, "the volume", [&] {
    return volumes_.get(id.value, [&] {
      VolumeSum sum;
      for (TopExp_Explorer face(shapes_.solid(id), TopAbs_FACE); face.More(); face.Next()) {
        const TopAbs_Orientation orientation = face.Current().Orientation();
        if (orientation != TopAbs_FORWARD && orientation != TopAbs_REVERSED) continue;
        const int index = shapes_.faces.FindIndex(face.Current());
        sum.add(integrals(ModelFaceId(static_cast<std::size_t>(index - 1))), orientation == TopAbs_REVERSED);
      }
      return sum.volume();
    });
  });
}

}  // namespace tetloom::cad

#include "core/cad/detail/exact_frames.hpp"

#include <array>
#include <bit>
#include <BRep_CurveRepresentation.hxx>
#include <BRep_GCurve.hxx>
#include <BRep_TEdge.hxx>
#include <BRep_TFace.hxx>
#include <cmath>
#include <Geom2d_Conic.hxx>
#include <Geom2d_Line.hxx>
#include <Geom2d_OffsetCurve.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <Geom_Conic.hxx>
#include <Geom_ElementarySurface.hxx>
#include <Geom_Line.hxx>
#include <Geom_OffsetCurve.hxx>
#include <Geom_OffsetSurface.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SurfaceOfLinearExtrusion.hxx>
#include <Geom_SurfaceOfRevolution.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <TopExp.hxx>
#include <TopoDS.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <type_traits>

namespace tetloom::cad {
namespace {

/// Goes through all frames; `exchange` gets each one, and says whether the caller goes on with the one it has now.
template <class Exchange>
class FrameWalk {
 public:
  explicit FrameWalk(Exchange exchange) : exchange_(std::move(exchange)) {}

  void shape(const TopoDS_Shape& all) {
    TopTools_IndexedMapOfShape faces, edges;
    TopExp::MapShapes(all, TopAbs_FACE, faces);
    TopExp::MapShapes(all, TopAbs_EDGE, edges);
    for (int i = 1; i <= faces.Extent(); ++i) surface(Handle(BRep_TFace)::DownCast(faces(i).TShape())->Surface());
    for (int i = 1; i <= edges.Extent(); ++i)
      for (const Handle(BRep_CurveRepresentation) & one : Handle(BRep_TEdge)::DownCast(edges(i).TShape())->Curves()) {
        if (one->IsCurve3D()) curve(one->Curve3D());
        if (one->IsCurveOnSurface()) curve(one->PCurve());
        if (one->IsCurveOnClosedSurface()) curve(one->PCurve2());
      }
  }

 private:
  void surface(const Handle(Geom_Surface) & any) {
    if (const auto trimmed = Handle(Geom_RectangularTrimmedSurface)::DownCast(any))
      return surface(trimmed->BasisSurface());
    if (const auto offset = Handle(Geom_OffsetSurface)::DownCast(any)) return surface(offset->BasisSurface());
    if (const auto elementary = Handle(Geom_ElementarySurface)::DownCast(any)) {
      gp_Ax3 position = elementary->Position();
      if (exchange_(position)) elementary->SetPosition(position);
    } else if (const auto turned = Handle(Geom_SurfaceOfRevolution)::DownCast(any)) {
      gp_Ax1 axis = turned->Axis();
      if (exchange_(axis)) turned->SetAxis(axis);
      curve(turned->BasisCurve());
    } else if (const auto swept = Handle(Geom_SurfaceOfLinearExtrusion)::DownCast(any)) {
      gp_Dir direction = swept->Direction();
      if (exchange_(direction)) swept->SetDirection(direction);
      curve(swept->BasisCurve());
    }
  }

  void curve(const Handle(Geom_Curve) & any) {
    if (const auto trimmed = Handle(Geom_TrimmedCurve)::DownCast(any)) return curve(trimmed->BasisCurve());
    if (const auto line = Handle(Geom_Line)::DownCast(any)) {
      gp_Ax1 position = line->Position();
      if (exchange_(position)) line->SetPosition(position);
    } else if (const auto conic = Handle(Geom_Conic)::DownCast(any)) {
      gp_Ax2 position = conic->Position();
      if (exchange_(position)) conic->SetPosition(position);
    } else if (const auto offset = Handle(Geom_OffsetCurve)::DownCast(any)) {
      gp_Dir direction = offset->Direction();
      if (exchange_(direction)) offset->SetDirection(direction);
      curve(offset->BasisCurve());
    }
  }

  void curve(const Handle(Geom2d_Curve) & any) {
    if (const auto trimmed = Handle(Geom2d_TrimmedCurve)::DownCast(any)) return curve(trimmed->BasisCurve());
    if (const auto offset = Handle(Geom2d_OffsetCurve)::DownCast(any)) return curve(offset->BasisCurve());
    if (const auto line = Handle(Geom2d_Line)::DownCast(any)) {
      gp_Ax2d position = line->Position();
      if (exchange_(position)) line->SetPosition(position);
    } else if (const auto conic = Handle(Geom2d_Conic)::DownCast(any)) {
      gp_Ax22d position = conic->Position();
      if (exchange_(position)) conic->SetAxis(position);
    }
  }

  Exchange exchange_;
};

/// A frame as its coordinates.
template <class Frame>
using Coordinates = std::array<double, sizeof(Frame) / sizeof(double)>;

}  // namespace

std::vector<double> frames_of(const TopoDS_Shape& shape) {
  std::vector<double> frames;
  FrameWalk([&](const auto& frame) {
    const auto coordinates = std::bit_cast<Coordinates<std::decay_t<decltype(frame)>>>(frame);
    frames.insert(frames.end(), coordinates.begin(), coordinates.end());
    return false;
  }).shape(shape);
  return frames;
}

bool set_frames(const TopoDS_Shape& shape, const std::vector<double>& frames) {
  constexpr double kSame = 1e-9;  // of unit vectors and of places; what differs by more is another frame
  bool fits = true;
  std::size_t at = 0;
  FrameWalk([&](auto& frame) {
    using Frame = std::decay_t<decltype(frame)>;
    const auto read = std::bit_cast<Coordinates<Frame>>(frame);
    Coordinates<Frame> written;
    fits &= frames.size() - at >= written.size();
    if (!fits) return false;
    for (std::size_t i = 0; i < written.size(); ++i) {
      written[i] = frames[at++];
      fits &= std::abs(written[i] - read[i]) <= kSame * (1 + std::abs(read[i]));
    }
    frame = std::bit_cast<Frame>(written);
    return fits;
  }).shape(shape);
  return fits && at == frames.size();
}

}  // namespace tetloom::cad

#include "core/cad/detail/exact_locations.hpp"

#include <algorithm>
#include <bit>
#include <BRep_Builder.hxx>
#include <BRep_CurveRepresentation.hxx>
#include <BRep_ListOfCurveRepresentation.hxx>
#include <BRep_TEdge.hxx>
#include <BRep_TFace.hxx>
#include <gp_Trsf.hxx>
#include <set>
#include <span>
#include <TopoDS_Iterator.hxx>

namespace tetloom::cad {
namespace {

using Bits = std::array<double, 14>;

/// Locations in the order in which a walk through a shape meets them, each shape once.
class LocationWalk {
 public:
  explicit LocationWalk(std::vector<LocationFactors>& met) : met_(met) {}

  void visit(const TopoDS_Shape& shape) {
    if (!known_.insert(shape.TShape()).second) return;
    if (const auto face = Handle(BRep_TFace)::DownCast(shape.TShape())) add(face->Location());
    if (const auto edge = Handle(BRep_TEdge)::DownCast(shape.TShape()))
      for (const Handle(BRep_CurveRepresentation) & curve : edge->Curves()) add(curve->Location());
    for (TopoDS_Iterator child(shape, false, false); child.More(); child.Next()) {
      add(child.Value().Location());
      visit(child.Value());
    }
  }

 private:
  void add(const TopLoc_Location& location) { met_.push_back(factors_of(location)); }

  std::vector<LocationFactors>& met_;
  std::set<Handle(TopoDS_TShape)> known_;
};

/// Builds a shape again, in the same order, each of its parts once; `place` says where, from where it was.
template <class Place>
class Rebuilding {
 public:
  explicit Rebuilding(const Place& place) : place_(place) {}

  TopoDS_Shape rebuilt(const TopoDS_Shape& shape) {
    const auto known = made_.find(shape.TShape());
    if (known != made_.end()) return known->second;
    TopoDS_Shape result = shape.Located({}, false).EmptyCopied().Oriented(TopAbs_FORWARD);
    if (const auto face = Handle(BRep_TFace)::DownCast(result.TShape())) face->Location(place_(face->Location()));
    if (const auto edge = Handle(BRep_TEdge)::DownCast(result.TShape()))
      for (const Handle(BRep_CurveRepresentation) & curve : edge->ChangeCurves())  // copies, too
        curve->Location(place_(curve->Location()));
    BRep_Builder builder;
    for (TopoDS_Iterator child(shape, false, false); child.More(); child.Next()) {
      const TopLoc_Location place = place_(child.Value().Location());
      const TopoDS_Shape part = rebuilt(child.Value());
      builder.Add(result, part.Oriented(child.Value().Orientation()).Located(place, false));
    }
    result.Closed(shape.Closed());
    made_[shape.TShape()] = result;
    return result;
  }

 private:
  const Place& place_;
  std::map<Handle(TopoDS_TShape), TopoDS_Shape> made_;
};

}  // namespace

LocationFactors factors_of(TopLoc_Location location) {
  LocationFactors factors;
  for (; !location.IsIdentity(); location = location.NextLocation())
    factors.push_back({reinterpret_cast<std::uintptr_t>(location.FirstDatum().get()),
                       std::bit_cast<Bits>(location.FirstDatum()->Transformation()), location.FirstPower()});
  return factors;
}

// The first factor is the one that is applied first, so the last one stands in front.
TopLoc_Location LocationMaker::make(const LocationFactors& factors) {
  TopLoc_Location location;
  for (auto factor = factors.rbegin(); factor != factors.rend(); ++factor) {
    Handle(TopLoc_Datum3D)& datum = datums_[factor->datum];
    if (datum.IsNull()) datum = new TopLoc_Datum3D(std::bit_cast<gp_Trsf>(factor->transformation));
    location = location * TopLoc_Location(datum).Powered(static_cast<int>(factor->power));
  }
  return location;
}

TopoDS_Shape copy_of(const TopoDS_Shape& shape) {
  const auto stay = [](const TopLoc_Location& location) { return location; };
  return Rebuilding(stay).rebuilt(shape);
}

void put_locations(const TopoDS_Shape& shape, MessageWriter& writer) {
  std::vector<LocationFactors> met;
  LocationWalk(met).visit(shape);
  const bool any = std::ranges::any_of(met, [](const LocationFactors& factors) { return !factors.empty(); });
  writer.put(static_cast<std::uint64_t>(any ? met.size() : 0));
  if (!any) return;
  for (const LocationFactors& factors : met) writer.put_array(std::span<const LocationFactor>(factors));
}

TopoDS_Shape with_locations(const TopoDS_Shape& read, MessageReader& locations, LocationMaker& maker) {
  std::vector<LocationFactors> all(locations.get<std::uint64_t>());
  if (all.empty()) return read;
  for (LocationFactors& factors : all) factors = locations.get_array<LocationFactor>();
  std::size_t next = 0;
  const auto take_next = [&](const TopLoc_Location&) {
    if (next == all.size()) throw Error(ErrorCode::Internal, "a stored shape has other parts");
    return maker.make(all[next++]);
  };
  TopoDS_Shape shape = Rebuilding(take_next).rebuilt(read);
  if (next != all.size()) throw Error(ErrorCode::Internal, "a stored shape has other parts");
  return shape;
}

}  // namespace tetloom::cad

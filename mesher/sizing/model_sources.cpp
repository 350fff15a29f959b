#include "mesher/sizing/model_sources.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/base/lists.hpp"
#include "core/sizing/curvature_size.hpp"
#include "mesher/sizing/facet_refiner.hpp"
#include "mesher/sizing/narrow_entities.hpp"
#include "mesher/sizing/volume_floors.hpp"
#include "mesher/sizing/wire_faces.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {
namespace {

/// The floor on wires and balls, as a share of the usual one: nothing that is seen is thinner, and tiny ones stay
/// cheap.
constexpr double kWireFloor = 0.05;

/// Cuts an edge into segments on which one size holds and which stay close to it.
class EdgeSplitter {
 public:
  EdgeSplitter(EdgeGeometry& edge, double cap, const SizeTargets& targets)
      : edge_(edge), cap_(std::min(cap, targets.global)), targets_(targets) {}

  std::vector<SizeSource> run() {
    constexpr int kPieces = 8, kDepth = 12;
    const ParameterRange range = edge_.range();
    const double step = (range.hi - range.lo) / kPieces;
    Vec3 start = edge_.evaluate(range.lo);
    for (int i = 0; i < kPieces; ++i) {
      const Vec3 end = edge_.evaluate(range.lo + (i + 1) * step);
      cut({range.lo + i * step, range.lo + (i + 1) * step}, start, end, kDepth);
      start = end;
    }
    return std::move(out_);
  }

 private:
  double size_at(double t) {
    if (targets_.curvature <= 0) return cap_;
    const double wish = size_from_edge_curvature(edge_.curvature(t), targets_.curvature);
    return std::min(cap_, std::max(wish, targets_.floor));
  }

  void cut(const ParameterRange& range, const Vec3& start, const Vec3& end, int depth) {
    constexpr double kSpread = 1.15, kSag = 0.1;
    const double width = range.hi - range.lo, middle = range.lo + 0.5 * width;
    const double s0 = size_at(range.lo + 0.15 * width), s1 = size_at(middle), s2 = size_at(range.hi - 0.15 * width);
    const double smallest = std::min({s0, s1, s2}), largest = std::max({s0, s1, s2});
    if (smallest >= targets_.global) return;
    const Vec3 halfway = edge_.evaluate(middle);
    const bool bends = distance(halfway, 0.5 * (start + end)) > kSag * smallest;
    const bool varies = largest > kSpread * smallest && distance(start, end) > 0.5 * smallest;
    if (depth > 0 && (bends || varies)) {
      cut({range.lo, middle}, start, halfway, depth - 1);
      cut({middle, range.hi}, halfway, end, depth - 1);
    } else if (smallest < targets_.global) {
      out_.push_back({start, end, end, smallest});
    }
  }

  EdgeGeometry& edge_;
  double cap_;
  const SizeTargets& targets_;
  std::vector<SizeSource> out_;
};

/// The least limit of the faces at each edge.
std::vector<double> small_edge_limits(const ModelTopology& topology, const SmallWidth& small) {
  std::vector<double> limits(topology.edge_count(), HUGE_VAL);
  for (std::size_t f = 0; f < small.face_limits.size(); ++f)
    for (const ModelLoop& loop : topology.face_to_loops[f])
      for (const EdgeUse& use : loop) limits[use.edge.value] = std::min(limits[use.edge.value], small.face_limits[f]);
  return limits;
}

SizeTargets without_curvature(SizeTargets targets) {
  targets.curvature = 0;
  return targets;
}

/// The sources of one face.
class FaceSplitter {
 public:
  /// `curvature`: edges per turn; 0: off.
  FaceSplitter(FaceGeometry& face, double cap, double floor, double curvature, const SizeTargets& targets)
      : face_(face),
        floor_(floor),
        curvature_(curvature),
        smooth_(face.parametrization() == Parametrization::Smooth),
        rules_{.global = targets.global, .cap = cap, .longest = HUGE_VAL} {}

  std::vector<SizeSource> run(const Tessellation& facets, const TaskRunner& runner) {
    std::vector<SizeSource> out;
    std::size_t visited = 0;
    for (const auto& tri : facets.tri_to_vert) {
      if (++visited % 256 == 0) runner.check_cancelled();
      FacetPiece piece;
      for (std::size_t i = 0; i < 3; ++i) piece[i] = {facets.uv[tri[i]], facets.points[tri[i]]};
      if (curvature_ <= 0) {
        if (rules_.cap < rules_.global) out.push_back({piece[0].point, piece[1].point, piece[2].point, rules_.cap});
      } else if (smooth_) {
        refine_smooth(piece, out);
      } else {
        add_flat(piece, out);
      }
    }
    return out;
  }

 private:
  double size_at(const Vec2& uv) const {
    return std::max(size_from_curvature(face_.curvature(uv), curvature_), floor_);
  }

  void refine_smooth(const FacetPiece& facet, std::vector<SizeSource>& out) const {
    const auto sample = [&](const FacetPiece& piece, const std::array<double, 3>& w) {
      return size_at(w[0] * piece[0].uv + w[1] * piece[1].uv + w[2] * piece[2].uv);
    };
    const auto middle = [&](const FacetCorner& a, const FacetCorner& b) {
      const Vec2 uv = 0.5 * (a.uv + b.uv);
      return FacetCorner{uv, face_.evaluate(uv)};
    };
    refine_facet(facet, rules_, sample, middle, out);
  }

  /// Facets of a discrete face: their corners are all that there is.
  void add_flat(const FacetPiece& piece, std::vector<SizeSource>& out) const {
    double smallest = std::min(rules_.cap, rules_.global);
    for (const FacetCorner& corner : piece) smallest = std::min(smallest, size_at(corner.uv));
    if (smallest < rules_.global) out.push_back({piece[0].point, piece[1].point, piece[2].point, smallest});
  }

  FaceGeometry& face_;
  double floor_, curvature_;
  bool smooth_;
  FacetRules rules_;
};

// By the mean curvature of the face.
double wire_floor(double weight, const Tessellation& facets, double edges_per_turn) {
  return 6 / (edges_per_turn * std::sqrt(weight / area_of(facets)));
}

/// What floors depend on.
struct FaceMeasures {
  double wire_weight = 0;  ///< 0 where the face is not of a wire
  CurvedFace curved;
};

std::vector<FaceMeasures> measure_faces(const GeometricModel& model, const SizeTargets& targets,
                                        const std::vector<Tessellation>& facets, const SharedWork& work) {
  const WireFinder wires(model, targets);
  auto lists = work.make_lists<FaceMeasures>(facet_counts(facets), [&](std::size_t f) {
    FaceMeasures measures;
    tolerate_bad_geometry([&] {
      const ModelFaceId face(f);
      const auto geometry = model.face_geometry(face);
      measures.wire_weight = wires.weight(face, *geometry, facets[f]);
      measures.curved = measure_curved_face(model, face, *geometry, facets[f], targets.curvature, targets.floor);
    });
    return std::vector{measures};
  });
  return joined(lists);
}

// That of wires lets them have so many edges per turn as can be afforded.
void lower_floors_of_wires(const std::vector<FaceMeasures>& faces, const SizeTargets& targets,
                           const std::vector<Tessellation>& facets, std::vector<double>& floors) {
  std::vector<double> weights;
  for (const FaceMeasures& face : faces) weights.push_back(face.wire_weight);
  const double edges = wire_edges_per_turn(weights, targets.curvature);
  if (edges <= 0) return;
  for (std::size_t f = 0; f < floors.size(); ++f) {
    if (weights[f] <= 0) continue;
    floors[f] = kWireFloor * targets.floor;
    if (edges < targets.curvature) floors[f] = std::max(floors[f], wire_floor(weights[f], facets[f], edges));
  }
}

// The floor for the curvature of every face.
std::vector<double> face_floors(const GeometricModel& model, const SizeTargets& targets,
                                const std::vector<Tessellation>& facets, const SharedWork& work) {
  std::vector<double> floors(facets.size(), targets.floor);
  for (std::size_t f = 0; f < targets.wires.size(); ++f)
    if (targets.wires[f] > 0) floors[f] = kWireFloor * targets.floor;
  if (targets.curvature <= 0 || !targets.floor_is_default) return floors;
  const std::vector<FaceMeasures> faces = measure_faces(model, targets, facets, work);
  lower_floors_of_wires(faces, targets, facets, floors);
  std::vector<CurvedFace> curved;  // but for wires, which have as many edges per turn as can be afforded
  for (std::size_t f = 0; f < faces.size(); ++f)
    curved.push_back(floors[f] < targets.floor ? CurvedFace{} : faces[f].curved);
  return lower_floors_for_volumes(model, curved, std::move(floors));
}

}  // namespace

std::vector<double> facet_counts(const std::vector<Tessellation>& facets) {
  std::vector<double> work;
  for (const Tessellation& face : facets) work.push_back(static_cast<double>(face.tri_to_vert.size()));
  return work;
}

std::vector<FacetTolerance> source_tolerances(const GeometricModel& model, const SizeTargets& targets) {
  constexpr double kAngle = 0.35;
  FacetTolerance usual{.chord = 0.1 * targets.global, .angle = kAngle};
  // An arc of 8/N radians between facets sags by 1.3/N of the size that the curvature rule gives: by 5 percent where N
  // is 24. Beyond, that is enough, and takes far fewer facets.
  constexpr double kFine = 24;
  if (targets.curvature > 0) {
    const double arc = 8 / std::min(targets.curvature, std::sqrt(kFine * targets.curvature));
    usual.angle = std::clamp(arc, 0.05, kAngle);
  }
  std::vector<FacetTolerance> tolerances(model.topology().face_count());
  for (std::size_t f = 0; f < tolerances.size(); ++f) {
    tolerances[f] = usual;
    if (targets.face[f] < targets.global) tolerances[f].chord = 0.1 * targets.face[f];
    if (targets.proximity > 0)
      tolerances[f].chord = std::min(tolerances[f].chord, std::max(0.25 * targets.floor, 1e-3 * targets.global));
  }
  return tolerances;
}

std::vector<SizeSource> edge_sources(const GeometricModel& model, const SizeTargets& targets, const SharedWork& work) {
  const ModelTopology& topology = model.topology();
  const std::vector<double> edges(topology.edge_count(), 1.0);
  const std::vector<double> edge_limits = small_edge_limits(topology, targets.small);
  auto lists = work.make_lists<SizeSource>(edges, [&](std::size_t e) {
    std::vector<SizeSource> list;
    if (topology.edges[e].degenerate) {
      const Vec3 pole = model.vertex_point(topology.edges[e].vertices[0]);
      if (targets.edge[e] < targets.global) list = {{pole, pole, pole, targets.edge[e]}};
    } else if (targets.curvature > 0 || targets.edge[e] < targets.global) {
      tolerate_bad_geometry([&] {
        const auto geometry = model.edge_geometry(ModelEdgeId(e));
        const double small = std::min(edge_limits[e], targets.small.on(std::min(targets.edge[e], targets.global)));
        const bool is_closed = topology.edges[e].vertices[0] == topology.edges[e].vertices[1];
        const bool is_small = small > 0 && !is_closed && length_up_to(*geometry, small) < small;
        list = EdgeSplitter(*geometry, targets.edge[e], is_small ? without_curvature(targets) : targets).run();
      });
    }
    return list;
  });
  lists.emplace_back();
  for (std::size_t v = 0; v < targets.vertex.size(); ++v) {
    if (targets.vertex[v] >= targets.global) continue;
    const Vec3 point = model.vertex_point(ModelVertexId(v));
    lists.back().push_back({point, point, point, targets.vertex[v]});
  }
  return joined(lists);
}

std::vector<SizeSource> face_sources(const GeometricModel& model, const SizeTargets& targets,
                                     const std::vector<Tessellation>& facets, const SharedWork& work) {
  const std::vector<double> floors = face_floors(model, targets, facets, work);
  return joined(work.make_lists<SizeSource>(facet_counts(facets), [&](std::size_t f) {
    std::vector<SizeSource> list;
    const double wire = targets.wires.empty() ? 0 : targets.wires[f];
    if (targets.curvature <= 0 && wire <= 0 && targets.face[f] >= targets.global) return list;
    tolerate_bad_geometry([&] {
      const auto geometry = model.face_geometry(ModelFaceId(f));
      // What has a floor below the usual one is no feature of something else.
      const double small = targets.small.on_face(f, std::min(targets.face[f], targets.global));
      const bool is_small =
          small > 0 && floors[f] >= targets.floor && mean_width(model, ModelFaceId(f), facets[f]) < small;
      const double floor = is_small ? targets.global : floors[f];
      const double curvature = std::max(targets.curvature, wire);
      list = FaceSplitter(*geometry, targets.face[f], floor, curvature, targets).run(facets[f], work.runner());
    });
    return list;
  }));
}

}  // namespace tetloom

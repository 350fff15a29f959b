#include "mesher/surface/face_mesher.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/disjoint_sets.hpp"
#include "mesher/surface/face_plane.hpp"
#include "mesher/surface/facet_patch.hpp"
#include "mesher/surface/frontal_delaunay.hpp"
#include "mesher/surface/narrow_tubes.hpp"
#include "mesher/surface/patch_optimizer.hpp"
#include "mesher/surface/rim_patch.hpp"

namespace tetloom {

RimNodes::RimNodes(const GeometricModel& model, const std::vector<EdgeMesh>& edges)
    : topology_(model.topology()), edges_(edges) {
  for (std::uint32_t v = 0; v < topology_.vertex_count; ++v) {
    points_.push_back(model.vertex_point(ModelVertexId(v)));
    classification_.push_back(ModelVertexId(v));
  }
  for (std::size_t e = 0; e < edges.size(); ++e) {
    edge_first_.push_back(count());
    if (edges[e].joined_to.valid()) continue;
    points_.insert(points_.end(), edges[e].points.begin() + 1, edges[e].points.end() - 1);
    classification_.resize(points_.size(), ModelEdgeId(e));
  }
}

std::uint32_t RimNodes::node(ModelEdgeId edge, std::size_t i) const {
  if (i == 0) return topology_.edges[edge.value].vertices[0].value;
  if (i + 1 == edges_[edge.value].points.size()) return topology_.edges[edge.value].vertices[1].value;
  const EdgeMesh& mesh = edges_[edge.value];
  if (mesh.joined_to.valid()) return node(mesh.joined_to, mesh.reversed ? mesh.points.size() - 1 - i : i);
  return edge_first_[edge.value] + static_cast<std::uint32_t>(i - 1);
}

std::vector<std::uint32_t> RimNodes::renumbered(const RimNodes& other) const {
  std::vector<std::uint32_t> numbers(count(), Triangulation::kNone);
  for (std::uint32_t v = 0; v < topology_.vertex_count; ++v) numbers[v] = v;
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    const std::size_t pieces = edges_[e].points.size();
    if (pieces != other.edges_[e].points.size() || edges_[e].joined_to.valid()) continue;
    for (std::size_t i = 0; i + 2 < pieces; ++i)
      numbers[edge_first_[e] + i] = other.edge_first_[e] + static_cast<std::uint32_t>(i);
  }
  return numbers;
}

namespace {

class FaceMesher {
  using Chord = std::array<std::uint32_t, 2>;  // two nodes, ascending

 public:
  FaceMesher(const GeometricModel& model, ModelFaceId face, const FaceSurroundings& surroundings,
             const std::function<bool()>& keep_going)
      : model_(model),
        face_(face),
        rim_(surroundings.rim),
        sizes_(surroundings.sizes),
        taken_chords_(surroundings.taken_chords),
        last_attempt_(surroundings.last_attempt),
        kept_(surroundings.kept_facets),
        keep_going_(keep_going),
        geometry_(model.face_geometry(face)) {}

  // Each way is tried where the ones before gave no mesh, or one with triangles that face away from the surface.
  FaceMesh run() {
    if (geometry_->parametrization() != Parametrization::Smooth) {
      mesh_facets();
      return std::move(result_);
    }
    mesh_in_plane();
    FaceMesh best = std::exchange(result_, {});
    if (is_sound(best)) return best;
    if (bounds_nothing()) return {};
    const auto try_other = [&](auto&& mesh) {
      try {
        mesh();
      } catch (const Error& error) {
        if (error.code() == ErrorCode::Cancelled || error.code() == ErrorCode::OutOfMemory) throw;
        result_.verdict = FaceVerdict::NotTriangulated;
      }
      FaceMesh other = std::exchange(result_, {});
      const bool better =
          other.verdict == FaceVerdict::Ok && (best.verdict != FaceVerdict::Ok || other.inverted < best.inverted);
      if (better) best = std::move(other);
    };
    const bool may_become_finer = best.verdict == FaceVerdict::RimCrosses && !last_attempt_;
    if (best.verdict != FaceVerdict::Ok && !may_become_finer) try_other([&] { mesh_facets(); });
    for (const bool follow : {true, false})
      if (!is_sound(best) && is_affordable(best)) try_other([&] { mesh_over_plane(follow); });
    return best;
  }

 private:
  static bool is_sound(const FaceMesh& mesh) { return mesh.verdict == FaceVerdict::Ok && mesh.inverted == 0; }

  // Every point over the fitted plane asks the whole rim, and so do the points of the rim.
  bool is_affordable(const FaceMesh& mesh) const {
    constexpr std::size_t kMost = 5'000'000, kLongestRim = 2000;
    std::size_t pieces = 0;
    for (const ModelLoop& loop : model_.topology().face_to_loops[face_.value])
      for (const EdgeUse& use : loop) pieces += rim_.mesh(use.edge).points.size();
    return pieces <= kLongestRim && pieces * mesh.tri_to_vert.size() <= kMost;
  }

  // Has the face no area, between edges that lie on each other, or is it no wider than these are exact?
  bool bounds_nothing() const {
    const std::optional<double> length = length_of_cancelled_rim(model_.topology(), face_, rim_);
    if (!length) return false;
    constexpr double kNoArea = 0.01;  // of the squared length; a sphere along its seam has 0.3
    const double area = model_.area(face_), width = 2 * area / *length;
    return area <= kNoArea * *length * *length || width <= tolerance_of_rim();
  }

  double tolerance_of_rim() const {
    double tolerance = 0;
    for (const ModelLoop& loop : model_.topology().face_to_loops[face_.value])
      for (const EdgeUse& use : loop) tolerance = std::max(tolerance, model_.attributes(use.edge).tolerance);
    return tolerance;
  }

  static const char* why_not(FacetPatchVerdict verdict) {
    switch (verdict) {
      case FacetPatchVerdict::NotManifold: return "its facets are no surface with a rim on its edges";
      case FacetPatchVerdict::ChainsDisagree: return "the rim of its facets does not run along its edges";
      case FacetPatchVerdict::Stuck: return "its rim bounds no triangle";
      default: return "";
    }
  }

  // The face's facets, with the nodes of its edges as their rim, brought to the sizes asked for in space.
  void mesh_facets() {
    const double size = smallest_rim_size();
    constexpr double kChord = 0.02, kAngle = 0.3;
    const Tessellation tessellation = geometry_->tessellate(kChord * size, kAngle);
    const FacetPatch facets = make_facet_patch(tessellation, boundary_chains(), keep_going_,
                                               [&](const Vec3& x) { return sizes_.size_at(x); });
    if (facets.verdict != FacetPatchVerdict::Ok) {
      result_.verdict = FaceVerdict::NotTriangulated;
      result_.message = why_not(facets.verdict);
      result_.point = facets.trouble;
      return;
    }
    const PatchSurface surface(*geometry_, sizes_);
    Patch patch;
    for (std::size_t i = 0; i < facets.points.size(); ++i) {
      PatchVertex vertex{surface.nearest(facets.points[i], facets.uv[i]), 0, facets.node[i]};
      if (vertex.node != Triangulation::kNone) put_on_rim(vertex, facets.normals[i]);
      if (facets.normals[i] == Vec3{}) vertex.place.normal = {};
      vertex.size = surface.size_at(vertex.place.point);
      patch.vertices.push_back(vertex);
    }
    patch.topology =
        Triangulation::from_triangles(static_cast<std::uint32_t>(patch.vertices.size()), facets.tri_to_vert);
    fix_slits(patch);
    patch.has_poles = true;
    if (kept_ != nullptr && !kept_->empty()) fix_kept_facets(facets.points, patch);
    optimize_patch(patch, surface, {.rounds = 4, .adapt_density = true}, keep_going_);
    for (PatchVertex& vertex : patch.vertices)
      if (vertex.node != Triangulation::kNone && vertex.node >= kStill) vertex.node = Triangulation::kNone;
    split_taken_chords(patch, surface);
    extract(patch);
  }

  // A rim vertex is at its node, and faces as its own side of the rim does: a crease within the face has two.
  void put_on_rim(PatchVertex& vertex, const Vec3& normal) const {
    vertex.place.point = rim_.point(vertex.node);
    if (dot(normal, vertex.place.normal) > 0.5 || normal == Vec3{}) return;
    vertex.place = place_in_space(vertex.place.plane, vertex.place.point, normal);
  }

  // A crease of one piece that ends within the face at both ends: its two sides have the same corners.
  void fix_slits(Patch& patch) const {
    std::vector<std::array<std::uint32_t, 2>> slits;
    for (const ModelLoop& loop : model_.topology().face_to_loops[face_.value])
      for (const EdgeUse& use : loop)
        if (use.second_side && rim_.mesh(use.edge).t.size() == 2)
          slits.push_back({std::min(rim_.node(use.edge, 0), rim_.node(use.edge, 1)),
                           std::max(rim_.node(use.edge, 0), rim_.node(use.edge, 1))});
    std::sort(slits.begin(), slits.end());
    for (std::uint32_t h = 0; h < patch.topology.half_edges() && !slits.empty(); ++h) {
      const std::uint32_t a = patch.vertices[patch.topology.origin(h)].node;
      const std::uint32_t b = patch.vertices[patch.topology.target(h)].node;
      if (patch.topology.twin(h) == Triangulation::kNone || a == Triangulation::kNone || b == Triangulation::kNone)
        continue;
      const std::array<std::uint32_t, 2> ends{std::min(a, b), std::max(a, b)};
      if (std::binary_search(slits.begin(), slits.end(), ends)) patch.topology.fix(h, 2);
    }
  }

  // Nothing moves or changes in the balls in which the facets are kept.
  void fix_kept_facets(std::span<const Vec3> points, Patch& patch) const {
    std::vector<std::uint8_t> is_kept(points.size());
    for (std::uint32_t v = 0; v < points.size(); ++v) {
      is_kept[v] = kept_->holds(points[v]);
      if (!is_kept[v] || patch.vertices[v].node != Triangulation::kNone) continue;
      patch.vertices[v].place.point = points[v];
      patch.vertices[v].node = kStill | v;
    }
    Triangulation& topology = patch.topology;
    for (std::uint32_t h = 0; h < topology.half_edges(); ++h)
      if (is_kept[topology.origin(h)] && is_kept[topology.target(h)] && topology.fixed(h) == 0) topology.fix(h, 1);
  }

  // A face without edges takes the smallest size of the whole field.
  double smallest_rim_size() const {
    double size = HUGE_VAL;
    for (const ModelLoop& loop : model_.topology().face_to_loops[face_.value])
      for (const EdgeUse& use : loop)
        for (const Vec3& point : rim_.mesh(use.edge).points) size = std::min(size, sizes_.size_at(point));
    return std::isfinite(size) ? size : sizes_.smallest();
  }

  std::vector<BoundaryChain> boundary_chains() const {
    const ModelTopology& topology = model_.topology();
    std::vector<BoundaryChain> chains;
    for (const ModelLoop& loop : topology.face_to_loops[face_.value])
      for (const EdgeUse& use : loop) {
        const ModelEdgeTopology& edge = topology.edges[use.edge.value];
        if (edge.degenerate) continue;
        BoundaryChain chain{use, edge.vertices, {}};
        const EdgeMesh& mesh = rim_.mesh(use.edge);
        for (std::size_t i = 0; i < mesh.t.size(); ++i)
          chain.nodes.push_back({rim_.node(use.edge, i), mesh.t[i], mesh.points[i]});
        chains.push_back(std::move(chain));
      }
    return chains;
  }

  void mesh_in_plane() { fill(make_rim_patch(model_.topology(), face_, *geometry_, rim_, sizes_), *geometry_); }

  // From the nodes of the edges, over the plane that fits them best; inside, on the surface where `follow` says so.
  void mesh_over_plane(bool follow) {
    result_.verdict = FaceVerdict::NotTriangulated;
    const std::optional<FittedPlane> plane = fit_plane(model_.topology(), face_, rim_);
    if (!plane) return;
    FaceRim rim = trace_rim(model_.topology(), face_, *plane, rim_);
    if (rim.segments.empty()) return;
    FaceOverPlane geometry(*geometry_, *plane, rim, rim_.points(), follow);
    result_.verdict = FaceVerdict::Ok;
    fill(fill_rim_patch(std::move(rim), geometry, rim_.points(), sizes_), geometry);
    if (!is_in_one_piece(result_)) result_.verdict = FaceVerdict::NotTriangulated;
  }

  // A thin tube without its seam is two caps over the plane.
  static bool is_in_one_piece(const FaceMesh& mesh) {
    std::vector<std::pair<std::array<std::uint32_t, 2>, std::uint32_t>> edges;
    for (std::uint32_t t = 0; t < mesh.tri_to_vert.size(); ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const auto [low, high] = std::minmax(mesh.tri_to_vert[t][i], mesh.tri_to_vert[t][(i + 1) % 3]);
        edges.push_back({{low, high}, t});
      }
    std::sort(edges.begin(), edges.end());
    DisjointSets pieces(mesh.tri_to_vert.size());
    for (std::size_t i = 0; i + 1 < edges.size(); ++i)
      if (edges[i].first == edges[i + 1].first) pieces.join(edges[i].second, edges[i + 1].second);
    for (std::uint32_t t = 1; t < mesh.tri_to_vert.size(); ++t)
      if (pieces.find(t) != pieces.find(0)) return false;
    return true;
  }

  void fill(RimPatch given, FaceGeometry& geometry) {
    const PatchSurface surface(geometry, sizes_, given.scale);
    if (given.polygon.verdict != PolygonVerdict::Ok) return explain(given);
    Patch patch{std::move(given.polygon.triangulation), std::move(given.vertices), given.rim.repeats_nodes};
    reserve_expected(patch);
    refine_frontal(patch, surface, keep_going_);
    sort_spatially(patch);
    optimize_patch(patch, surface, {}, keep_going_);
    if (patch.has_poles) open_narrow_tubes(patch, surface);
    split_taken_chords(patch, surface);
    extract(patch);
  }

  // The nodes that an edge of the patch joins; nothing where one of its ends is none.
  static std::optional<Chord> chord_of(const Patch& patch, std::uint32_t h) {
    const std::uint32_t a = patch.vertices[patch.topology.origin(h)].node;
    const std::uint32_t b = patch.vertices[patch.topology.target(h)].node;
    if (a == Triangulation::kNone || b == Triangulation::kNone || a == b) return {};
    return Chord{std::min(a, b), std::max(a, b)};
  }

  // Nodes that several edges of the patch join, one of them inside: as where both sides of a sharp corner belong to one
  // face. Both sides of an edge within the face are one edge. Ascending.
  static std::vector<Chord> find_repeated_chords(const Patch& patch) {
    std::vector<Chord> repeated;
    for (const NamedEdge& edge : find_edges_alike(patch))
      if (edge.ends[1] < NamedEdge::kInnerVertex) repeated.push_back(edge.ends);
    return repeated;
  }

  void split_taken_chords(Patch& patch, const PatchSurface& surface) const {
    Triangulation& topology = patch.topology;
    // In a plane, repeated chords are those of narrow tubes, which may stay where none is closed around them.
    const std::vector<Chord> repeated = surface.smooth() ? std::vector<Chord>{} : find_repeated_chords(patch);
    if (taken_chords_.empty() && repeated.empty()) return;
    const std::uint32_t end = topology.half_edges();
    for (std::uint32_t h = 0; h < end; ++h) {
      if (!topology.alive(h / 3) || !is_inner_edge(topology, h)) continue;
      const std::optional<Chord> chord = chord_of(patch, h);
      if (!chord ||
          (!std::ranges::binary_search(taken_chords_, *chord) && !std::ranges::binary_search(repeated, *chord)))
        continue;
      split_in_middle(patch, surface, h);
    }
  }

  void explain(const RimPatch& given) {
    const auto& [rim, scale, vertices, polygon] = given;
    const auto segment_point = [&](std::uint32_t s) { return given.vertices[given.rim.segments[s][0]].place.point; };
    result_.verdict = FaceVerdict::RimCrosses;
    switch (polygon.verdict) {
      case PolygonVerdict::SegmentsCross:
        result_.crossing_edges = {rim.segment_to_edge[polygon.first], rim.segment_to_edge[polygon.second]};
        result_.point = segment_point(polygon.first);
        break;
      case PolygonVerdict::PointOnSegment:
        result_.crossing_edges = {rim.segment_to_edge[polygon.first]};
        add_edges_at(polygon.second, rim);
        result_.point = vertices[polygon.second].place.point;
        break;
      case PolygonVerdict::DuplicatePoint:
        add_edges_at(polygon.first, rim);
        add_edges_at(polygon.second, rim);
        result_.point = vertices[polygon.second].place.point;
        break;
      case PolygonVerdict::NotClosed:
      case PolygonVerdict::Ok:
        result_.verdict = FaceVerdict::RimNotClosed;
        if (!vertices.empty()) result_.point = vertices.front().place.point;
        break;
    }
  }

  void add_edges_at(std::uint32_t vertex, const FaceRim& rim) {
    for (std::size_t s = 0; s < rim.segments.size(); ++s)
      if (rim.segments[s][0] == vertex || rim.segments[s][1] == vertex)
        result_.crossing_edges.push_back(rim.segment_to_edge[s]);
  }

  void extract(const Patch& patch) {
    const Triangulation& topology = patch.topology;
    std::vector<std::uint32_t> ids(patch.vertices.size(), Triangulation::kNone);
    const auto id_of = [&](std::uint32_t v) {
      const PatchVertex& vertex = patch.vertices[v];
      if (vertex.node != Triangulation::kNone) return vertex.node;
      if (ids[v] == Triangulation::kNone) {
        ids[v] = FaceMesh::kInner | static_cast<std::uint32_t>(result_.points.size());
        result_.points.push_back(vertex.place.point);
      }
      return ids[v];
    };
    for (std::uint32_t tri = 0; tri < topology.slots(); ++tri) {
      if (!topology.alive(tri)) continue;
      const auto [a, b, c] = topology.triangle(tri);
      const std::array nodes{id_of(a), id_of(b), id_of(c)};
      if (nodes[0] == nodes[1] || nodes[1] == nodes[2] || nodes[2] == nodes[0]) continue;
      result_.tri_to_vert.push_back(nodes);
      if (signed_quality(patch.vertices[a].place, patch.vertices[b].place, patch.vertices[c].place) <= 0) {
        ++result_.inverted;
        result_.point = patch.vertices[a].place.point;
      }
    }
    if (result_.tri_to_vert.empty()) result_.verdict = FaceVerdict::RimNotClosed;
    count_folds(patch);
  }

  // A parametrisation that folds over turns the normals with it: its triangles agree with them, and not with each
  // other.
  void count_folds(const Patch& patch) {
    constexpr double kFolded = -0.5;  // cosine
    const Triangulation& topology = patch.topology;
    const auto normal = [&](std::uint32_t tri) {
      const auto [a, b, c] = topology.triangle(tri);
      const Vec3& origin = patch.vertices[a].place.point;
      return normalized(cross(patch.vertices[b].place.point - origin, patch.vertices[c].place.point - origin));
    };
    for (std::uint32_t h = 0; h < topology.half_edges(); ++h) {
      const std::uint32_t g = topology.twin(h);
      if (!topology.alive(h / 3) || g == Triangulation::kNone || g < h) continue;
      if (dot(normal(h / 3), normal(g / 3)) > kFolded) continue;
      ++result_.inverted;
      result_.point = patch.vertices[topology.origin(h)].place.point;
    }
  }

  const GeometricModel& model_;
  ModelFaceId face_;
  const RimNodes& rim_;
  const SizeField& sizes_;
  std::span<const std::array<std::uint32_t, 2>> taken_chords_;
  bool last_attempt_;
  const KeptFacets* kept_;
  const std::function<bool()>& keep_going_;
  std::unique_ptr<FaceGeometry> geometry_;
  FaceMesh result_;
};

}  // namespace

FaceMesh mesh_face(const GeometricModel& model, ModelFaceId face, const FaceSurroundings& surroundings,
                   const std::function<bool()>& keep_going) {
  return FaceMesher(model, face, surroundings, keep_going).run();
}

}  // namespace tetloom

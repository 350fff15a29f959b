#include "mesher/surface/surface_mesher.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/lists.hpp"
#include "core/geometry/bad_geometry.hpp"
#include "core/sizing/size_change.hpp"
#include "mesher/surface/coincident_faces.hpp"
#include "mesher/surface/copied_surface.hpp"
#include "mesher/surface/drop_faces.hpp"
#include "mesher/surface/edge_mesher.hpp"
#include "mesher/surface/face_mesher.hpp"
#include "mesher/surface/faces_touched.hpp"
#include "mesher/surface/mesh_faces.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

class SurfaceMesher::State {
 public:
  State(const GeometricModel& model, const SharedWork& work)
      : model_(model), topology_(model.topology()), work_(work), runner_(work_.runner()), copies_(model, runner_) {
    options_.finer.assign(topology_.edge_count(), 1);
  }

  SurfaceMeshResult run(const SizeField& sizes) {
    const bool is_first = faces_.empty();
    faces_.resize(topology_.face_count());
    taken_chords_.clear();
    result_ = {};
    auto changes = is_first ? std::nullopt : find_changes(sizes_, sizes);
    if (changes) changes->insert(changes->end(), new_places_.begin(), new_places_.end());
    new_places_.clear();
    sizes_ = sizes;
    std::vector<std::size_t> pending = faces_to_mesh(changes);
    remeshed_ = 0;
    for (;;) {
      remeshed_ += pending.size();
      mesh_until_edges_fit(std::move(pending));
      copies_.carry_faces(sizes_, RimNodes(model_, edges_), faces_);
      pending = copies_.take_released();
      if (pending.empty()) break;
      remesh_edges();
    }
    separate_chords();
    assemble();
    return std::move(result_);
  }

  std::size_t remeshed() const { return remeshed_; }

  bool keep_facets(std::span<const KeptPlace> places) {
    const std::size_t before = new_places_.size();
    for (const KeptPlace& place : places) {
      const Vec3 reach{place.radius, place.radius, place.radius};
      if (kept_.add(place)) new_places_.push_back({place.center - reach, place.center + reach});
    }
    return new_places_.size() > before;
  }

 private:
  void mesh_until_edges_fit(std::vector<std::size_t> pending) {
    constexpr int kMostRounds = 6;
    for (int round = 0; round < kMostRounds && !pending.empty(); ++round) {
      if (round > 0) remesh_edges();
      last_attempt_ = round + 1 == kMostRounds;
      mesh_faces(pending);
      if (!last_attempt_) pending = refine_crossing_edges();
    }
  }

  // Meshes the edges with the present sizes. Faces have to follow that have another rim now, or other sizes near them.
  // `changes`: of the sizes, where they are known.
  std::vector<std::size_t> faces_to_mesh(const std::optional<std::vector<Box3>>& changes) {
    std::vector<bool> is_touched = changes ? find_faces_touched(*changes, faces_, RimNodes(model_, edges_), runner_)
                                           : std::vector<bool>(faces_.size(), true);
    const std::vector<EdgeMesh> old_edges = edges_;
    remesh_edges();
    for (const std::size_t f : copies_.take_released()) is_touched[f] = true;
    std::vector<std::size_t> pending;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (copies_.carries(f)) continue;
      if (is_touched[f] || faces_[f].verdict != FaceVerdict::Ok || !has_same_rim(f, old_edges)) pending.push_back(f);
    }
    return pending;
  }

  bool has_same_rim(std::size_t f, const std::vector<EdgeMesh>& old_edges) const {
    for (const ModelLoop& loop : topology_.face_to_loops[f])
      for (const EdgeUse& use : loop) {
        const EdgeMesh &now = edges_[use.edge.value], &before = old_edges[use.edge.value];
        if (now.t != before.t || now.joined_to != before.joined_to || now.reversed != before.reversed) return false;
        if (now.points.size() != before.points.size()) return false;
        for (std::size_t i = 0; i < now.points.size(); ++i)
          if (norm2(now.points[i] - before.points[i]) != 0) return false;
      }
    return true;
  }

  // Faces that are not meshed again keep their triangles, under the new numbers of their rim nodes.
  void remesh_edges() {
    const std::vector<EdgeMesh> old_edges = std::move(edges_);
    edges_ = mesh_edges(model_, sizes_, options_, runner_);
    kept_.put_on_edges(model_, edges_);
    copies_.carry_edges(sizes_, edges_);
    if (old_edges.empty()) return;
    const std::vector<std::uint32_t> numbers = RimNodes(model_, old_edges).renumbered(RimNodes(model_, edges_));
    for_triangle_blocks([&](const TriangleBlock& block) {
      for (std::size_t t = block.begin; t < block.end; ++t)
        for (std::uint32_t& v : faces_[block.face].tri_to_vert[t])
          if (!(v & FaceMesh::kInner)) v = numbers[v];
    });
  }

  void mesh_faces(const std::vector<std::size_t>& pending) {
    const RimNodes rim(model_, edges_);
    tetloom::mesh_faces(model_, pending, {rim, sizes_, taken_chords_, last_attempt_, &kept_}, work_, faces_);
  }

  // Doubles the pieces of the edges that cross; returns the faces to mesh again.
  std::vector<std::size_t> refine_crossing_edges() {
    std::vector<bool> refined(topology_.edge_count(), false);
    for (const FaceMesh& face : faces_)
      for (const ModelEdgeId edge : face.crossing_edges)
        if (!topology_.edges[edge.value].degenerate) refined[edge.value] = true;
    refine_joined(refined);
    std::vector<std::size_t> pending;
    for (std::size_t f = 0; f < topology_.face_count(); ++f) {
      bool touched = false;
      for (const ModelLoop& loop : topology_.face_to_loops[f])
        for (const EdgeUse& use : loop) touched = touched || refined[use.edge.value];
      if (touched && !copies_.carries(f)) pending.push_back(f);
    }
    for (std::size_t e = 0; e < refined.size(); ++e)
      if (refined[e]) options_.finer[e] *= 2;
    return pending;
  }

  // Edges with the same nodes become finer together.
  void refine_joined(std::vector<bool>& refined) const {
    for (std::size_t e = 0; e < refined.size(); ++e)
      if (edges_[e].joined_to.valid() && refined[e]) refined[edges_[e].joined_to.value] = true;
    for (std::size_t e = 0; e < refined.size(); ++e)
      if (edges_[e].joined_to.valid() && refined[edges_[e].joined_to.value]) refined[e] = true;
  }

  // Two narrow faces may both have an edge between the same two rim nodes (a tube of two halves, a few pieces each),
  // which would then belong to four triangles. Such faces are meshed again with these edges split.
  void separate_chords() {
    const RimNodes rim(model_, edges_);
    std::vector<Chord> chords;
    std::vector<NodePair> pieces;
    collect_chords(rim, chords);
    for (std::size_t e = 0; e < edges_.size(); ++e) append_pieces(ModelEdgeId(e), rim, pieces);
    for (const NodePair& piece : pieces) chords.push_back({piece, kModelEdge});
    std::sort(chords.begin(), chords.end());
    std::vector<std::size_t> pending;
    for (std::size_t i = 0; i < chords.size(); ++i) {
      const bool repeated = (i > 0 && chords[i - 1].nodes == chords[i].nodes) ||
                            (i + 1 < chords.size() && chords[i + 1].nodes == chords[i].nodes);
      if (!repeated || chords[i].face == kModelEdge) continue;
      pending.push_back(chords[i].face);
      if (taken_chords_.empty() || taken_chords_.back() != chords[i].nodes) taken_chords_.push_back(chords[i].nodes);
    }
    sort_unique(pending);
    if (!pending.empty()) mesh_faces(pending);
  }

  struct Chord {
    std::array<std::uint32_t, 2> nodes;  // smaller first
    std::uint32_t face;                  // kModelEdge for pieces of model edges
    auto operator<=>(const Chord&) const = default;
  };
  static constexpr std::uint32_t kModelEdge = 0xffffffffu;

  using NodePair = std::array<std::uint32_t, 2>;

  // Edges inside a face between two rim nodes: pairs with two triangle sides more than the face's loops account for.
  void collect_chords(const RimNodes& rim, std::vector<Chord>& chords) const {
    std::vector<std::vector<NodePair>> block_to_sides(triangle_blocks().size());
    for_triangle_blocks([&](const TriangleBlock& block) {
      for (std::size_t t = block.begin; t < block.end; ++t) {
        const auto& tri = faces_[block.face].tri_to_vert[t];
        for (std::size_t i = 0; i < 3; ++i) {
          const std::uint32_t a = tri[i], b = tri[(i + 1) % 3];
          if (!((a | b) & FaceMesh::kInner)) block_to_sides[block.number].push_back({std::min(a, b), std::max(a, b)});
        }
      }
    });
    std::vector<std::vector<NodePair>> face_to_sides(faces_.size());
    for (const TriangleBlock& block : triangle_blocks()) {
      std::vector<NodePair>& sides = face_to_sides[block.face];
      sides.insert(sides.end(), block_to_sides[block.number].begin(), block_to_sides[block.number].end());
    }
    std::vector<std::vector<Chord>> face_to_chords(faces_.size());
    runner_.for_each(faces_.size(), [&](std::size_t f) {
      face_to_chords[f] = find_chords(static_cast<std::uint32_t>(f), std::move(face_to_sides[f]), rim);
    });
    for (const auto& list : face_to_chords) chords.insert(chords.end(), list.begin(), list.end());
  }

  // `sides`: of the face's triangles, between two rim nodes.
  std::vector<Chord> find_chords(std::uint32_t f, std::vector<NodePair> sides, const RimNodes& rim) const {
    std::vector<Chord> chords;
    std::vector<NodePair> pieces;
    for (const ModelLoop& loop : topology_.face_to_loops[f])
      for (const EdgeUse& use : loop) append_pieces(use.edge, rim, pieces);
    std::sort(sides.begin(), sides.end());
    std::sort(pieces.begin(), pieces.end());
    for (auto side = sides.begin(); side != sides.end();) {
      const auto next = std::upper_bound(side, sides.end(), *side);
      const auto own = std::equal_range(pieces.begin(), pieces.end(), *side);
      if (next - side - (own.second - own.first) >= 2) chords.push_back({*side, f});
      side = next;
    }
    return chords;
  }

  // Triangles [begin, end) of a face.
  struct TriangleBlock {
    std::uint32_t face;
    std::size_t number, begin, end;
  };

  std::vector<TriangleBlock> triangle_blocks() const {
    constexpr std::size_t kBlock = std::size_t{1} << 14;
    std::vector<TriangleBlock> blocks;
    for (std::uint32_t f = 0; f < faces_.size(); ++f)
      for (std::size_t begin = 0; begin < faces_[f].tri_to_vert.size(); begin += kBlock)
        blocks.push_back({f, blocks.size(), begin, std::min(begin + kBlock, faces_[f].tri_to_vert.size())});
    return blocks;
  }

  template <class Body>
  void for_triangle_blocks(const Body& body) const {
    const std::vector<TriangleBlock> blocks = triangle_blocks();
    runner_.for_each(blocks.size(), [&](std::size_t b) { body(blocks[b]); });
  }

  void append_pieces(ModelEdgeId edge, const RimNodes& rim, std::vector<NodePair>& pieces) const {
    if (topology_.edges[edge.value].degenerate) return;
    for (std::size_t i = 0; i + 1 < edges_[edge.value].t.size(); ++i) {
      const std::uint32_t a = rim.node(edge, i), b = rim.node(edge, i + 1);
      pieces.push_back({std::min(a, b), std::max(a, b)});
    }
  }

  void assemble() {
    const RimNodes rim(model_, edges_);
    Mesh& mesh = result_.mesh;
    mesh.points = rim.points();
    for (std::uint32_t node = 0; node < rim.count(); ++node) mesh.point_to_entity.push_back(rim.classification(node));
    add_edges(rim);
    const std::vector<bool> cancelled = find_cancelled(rim);
    add_faces();
    const bool joined =
        std::any_of(edges_.begin(), edges_.end(), [](const EdgeMesh& e) { return e.joined_to.valid(); });
    if (joined || std::find(cancelled.begin(), cancelled.end(), true) != cancelled.end()) drop_faces(cancelled, mesh);
    mesh.face_to_sides = topology_.face_to_sides;
    for (int dim = 0; dim < 4; ++dim)
      for (std::size_t i = 0; i < topology_.count(dim); ++i)
        mesh.entities[static_cast<std::size_t>(dim)].push_back(model_.attributes({dim, static_cast<std::uint32_t>(i)}));
  }

  // By face. What lies between two coincident faces has no thickness, and the mesh goes without it.
  std::vector<bool> find_cancelled(const RimNodes& rim) {
    std::vector<bool> cancelled(faces_.size(), false);
    for (const auto& [first, second] : find_cancelling_faces(model_, rim, faces_)) {
      cancelled[first.value] = cancelled[second.value] = true;
      const Vec3 place = model_.vertex_point(
          topology_.edges[topology_.face_to_loops[first.value].front().front().edge.value].vertices[0]);
      result_.warnings.push_back({ErrorCode::InputUnsuitable,
                                  "two faces lie on each other with nothing between them, and are left out",
                                  {model_.named(first), model_.named(second)},
                                  place,
                                  {}});
    }
    report_flat_regions(cancelled);
    return cancelled;
  }

  // Solids without any triangle. Where the model itself gives one no volume the others do without it.
  void report_flat_regions(const std::vector<bool>& cancelled) {
    std::vector<ModelRegionId> flat;
    for (std::uint32_t r = 0; r < topology_.region_count(); ++r)
      if (is_flat(ModelRegionId(r), cancelled)) flat.push_back(ModelRegionId(r));
    for (const ModelRegionId region : flat) {
      std::vector<NamedEntity> entities{model_.named(region)};
      for (const ModelFaceId face : topology_.region_to_faces[region.value]) entities.push_back(model_.named(face));
      if (flat.size() < topology_.region_count() && has_no_volume(region)) {
        result_.warnings.push_back({ErrorCode::InputUnsuitable,
                                    "the solid has no volume, as its faces lie on each other, and is left out",
                                    std::move(entities),
                                    {},
                                    {}});
      } else {
        result_.errors.push_back({ErrorCode::VolumeFailed,
                                  "the solid encloses no volume: its faces lie on each other",
                                  std::move(entities),
                                  point_of(region),
                                  {}});
      }
    }
  }

  // A vertex; none where no edge has one.
  std::optional<Vec3> point_of(ModelRegionId region) const {
    for (const ModelFaceId face : topology_.region_to_faces[region.value])
      for (const ModelLoop& loop : topology_.face_to_loops[face.value])
        for (const EdgeUse& use : loop)
          if (const ModelVertexId vertex = topology_.edges[use.edge.value].vertices[0]; vertex.valid())
            return model_.vertex_point(vertex);
    return {};
  }

  bool is_flat(ModelRegionId region, const std::vector<bool>& cancelled) const {
    return std::ranges::all_of(topology_.region_to_faces[region.value], [&](ModelFaceId face) {
      const FaceMesh& mesh = faces_[face.value];
      return cancelled[face.value] || (mesh.verdict == FaceVerdict::Ok && mesh.tri_to_vert.empty());
    });
  }

  // Whether it is thinner, by its faces, than so many of the model's diagonal: nothing but rounding.
  bool has_no_volume(ModelRegionId region) const {
    constexpr double kNoThickness = 1e-8;
    double area = 0;
    for (const ModelFaceId face : topology_.region_to_faces[region.value])
      tolerate_bad_geometry([&] { area += model_.area(face); });
    const Box3 box = model_.bounding_box();
    return std::abs(model_.volume(region)) <= kNoThickness * norm(box.hi - box.lo) * area;
  }

  void add_edges(const RimNodes& rim) {
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      if (topology_.edges[e].degenerate || edges_[e].joined_to.valid()) continue;
      for (std::size_t i = 0; i + 1 < edges_[e].t.size(); ++i) {
        result_.mesh.edge_to_vert.push_back({rim.node(ModelEdgeId(e), i), rim.node(ModelEdgeId(e), i + 1)});
        result_.mesh.edge_to_entity.push_back(static_cast<std::uint32_t>(e));
      }
    }
  }

  void add_faces() {
    Mesh& mesh = result_.mesh;
    std::vector<std::size_t> first_point{mesh.points.size()}, first_triangle{0};
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (faces_[f].verdict != FaceVerdict::Ok) drop_face(f);
      first_point.push_back(first_point.back() + faces_[f].points.size());
      first_triangle.push_back(first_triangle.back() + faces_[f].tri_to_vert.size());
      if (faces_[f].inverted > 0) warn_of_inverted(f);
    }
    mesh.points.resize(first_point.back());
    mesh.point_to_entity.resize(first_point.back());
    mesh.tri_to_vert.resize(first_triangle.back());
    mesh.tri_to_entity.resize(first_triangle.back());
    for_triangle_blocks([&](const TriangleBlock& block) {
      const FaceMesh& face = faces_[block.face];
      const auto first = static_cast<std::uint32_t>(first_point[block.face]);
      for (std::size_t t = block.begin; t < block.end; ++t) {
        std::array<std::uint32_t, 3> tri = face.tri_to_vert[t];
        for (std::uint32_t& v : tri)
          if (v & FaceMesh::kInner) v = first + (v & ~FaceMesh::kInner);
        mesh.tri_to_vert[first_triangle[block.face] + t] = tri;
        mesh.tri_to_entity[first_triangle[block.face] + t] = block.face;
      }
      // There are fewer points than triangles, or about one more.
      const bool is_last = block.end == face.tri_to_vert.size();
      const std::size_t end = is_last ? face.points.size() : std::min(block.end, face.points.size());
      for (std::size_t p = std::min(block.begin, end); p < end; ++p) {
        mesh.points[first + p] = face.points[p];
        mesh.point_to_entity[first + p] = ModelFaceId(block.face);
      }
    });
  }

  void drop_face(std::size_t f) {
    report(f);
    faces_[f].points.clear();
    faces_[f].tri_to_vert.clear();
    faces_[f].inverted = 0;
  }

  void warn_of_inverted(std::size_t f) {
    result_.warnings.push_back({ErrorCode::FaceFailed,
                                std::to_string(faces_[f].inverted) + " triangles face away from the surface",
                                {model_.named(ModelFaceId(f))},
                                faces_[f].point,
                                {}});
  }

  void report(std::size_t f) {
    const FaceMesh& face = faces_[f];
    std::string message = "the face could not be triangulated";
    if (face.verdict == FaceVerdict::RimCrosses) message = "pieces of the face's edges cross each other";
    if (face.verdict == FaceVerdict::RimNotClosed) message = "the face's edges do not bound an area";
    if (!face.message.empty()) message += ": " + face.message;
    std::vector<NamedEntity> entities{model_.named(ModelFaceId(f))};
    for (const ModelEdgeId edge : face.crossing_edges) entities.push_back(model_.named(edge));
    result_.errors.push_back({ErrorCode::FaceFailed, message, std::move(entities), face.point, {}});
  }

  const GeometricModel& model_;
  const ModelTopology& topology_;
  const SharedWork work_;
  const TaskRunner& runner_;
  CopiedSurface copies_;
  SizeField sizes_ = SizeField::uniform(1);
  std::size_t remeshed_ = 0;
  EdgeMeshOptions options_;
  KeptFacets kept_;
  std::vector<Box3> new_places_;  // of those kept since the last call
  bool last_attempt_ = false;
  std::vector<EdgeMesh> edges_;
  std::vector<FaceMesh> faces_;
  std::vector<std::array<std::uint32_t, 2>> taken_chords_;  // sorted
  SurfaceMeshResult result_;
};

SurfaceMesher::SurfaceMesher(const GeometricModel& model, const SharedWork& work)
    : state_(std::make_unique<State>(model, work)) {}

SurfaceMesher::~SurfaceMesher() = default;

SurfaceMeshResult SurfaceMesher::mesh(const SizeField& sizes) { return state_->run(sizes); }

bool SurfaceMesher::keep_facets(std::span<const KeptPlace> places) { return state_->keep_facets(places); }

std::size_t SurfaceMesher::remeshed() const { return state_->remeshed(); }

SurfaceMeshResult mesh_surface(const GeometricModel& model, const SizeField& sizes, const SharedWork& work) {
  return SurfaceMesher(model, work).mesh(sizes);
}

}  // namespace tetloom

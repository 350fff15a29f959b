#include "mesher/layers/side_mesh.hpp"

#include <algorithm>
#include <iterator>
#include <unordered_map>
#include <utility>

#include "core/base/lists.hpp"
#include "mesher/surface/face_plane.hpp"
#include "mesher/surface/rim_mesh.hpp"

namespace tetloom::layers {
namespace {

class RestMesher {
 public:
  RestMesher(const SideFaces& sides, std::size_t side, std::span<const CurveTop> tops)
      : sides_(sides),
        side_(sides.sides()[side]),
        tops_(tops),
        geometry_(side_.shape.make_geometry(sides.model())),
        placer_(sides.model(), sides.mesh(), side_.shape, *geometry_) {
    result_.face = side_.shape.face.value;
  }

  SideMesh run(const SizeField& sizes, const std::function<bool()>& keep_going) {
    find_tops();
    for (const RimPiece& piece : side_.rim) add(piece);
    close_poles();
    RimMesh meshed = mesh(sizes, keep_going);
    result_.mesh = std::move(meshed.mesh);
    if (result_.mesh.verdict != FaceVerdict::Ok) find_in_the_way(meshed.crossing);
    return std::move(result_);
  }

 private:
  void find_tops() {
    for (const std::uint32_t c : side_.curves) {
      if (!tops_[c].grows) continue;
      vert_to_curve_[sides_.walls().curve_to_vert[c]] = c;
      for (const std::uint32_t v : sides_.dropped_by(c, tops_[c])) vert_to_curve_[v] = c;
    }
  }

  void add(const RimPiece& piece) {
    const std::uint32_t from = vertex(piece.verts[0], piece.places[0]), to = vertex(piece.verts[1], piece.places[1]);
    if (from == to) return;
    rim_.segments.push_back({from, to});
    rim_.segment_to_edge.emplace_back();
  }

  // The vertex of the plane's rim for a vertex of the face's rim at one of its places, or for the top that has taken
  // its place.
  std::uint32_t vertex(std::uint32_t vert, const Vec2& place) {
    const auto found = vert_to_curve_.find(vert);
    const bool is_top = found != vert_to_curve_.end();
    const std::uint32_t node = node_of(is_top ? SideMesh::Node{kNone, found->second} : SideMesh::Node{vert, kNone});
    return vertex_at(node, is_top ? placer_.beside(place, points_[node]) : place);
  }

  std::uint32_t node_of(const SideMesh::Node& node) {
    const std::uint64_t key = node.curve != kNone ? (std::uint64_t{1} << 32) + node.curve : node.vert;
    const auto [known, is_new] = nodes_.try_emplace(key, static_cast<std::uint32_t>(points_.size()));
    if (!is_new) return known->second;
    points_.push_back(node.curve != kNone ? tops_[node.curve].point : sides_.mesh().points[node.vert]);
    result_.nodes.push_back(node);
    node_to_vertices_.emplace_back();
    return known->second;
  }

  // Tops are looked for from both of their neighbours, so that their places differ by rounding.
  std::uint32_t vertex_at(std::uint32_t node, const Vec2& place) {
    constexpr double kSame = 1e-7;
    for (const std::uint32_t v : node_to_vertices_[node]) {
      const Vec2& other = rim_.vertices[v].uv;
      const double scale = 1 + std::max(norm(place), norm(other));
      if (norm(place - other) <= kSame * scale) return v;
    }
    rim_.repeats_nodes = rim_.repeats_nodes || !node_to_vertices_[node].empty();
    node_to_vertices_[node].push_back(static_cast<std::uint32_t>(rim_.vertices.size()));
    rim_.vertices.push_back({node, place});
    return node_to_vertices_[node].back();
  }

  // The rim arrives at one place of a pole and leaves from another one.
  void close_poles() {
    std::vector<int> leaving(rim_.vertices.size(), 0);
    for (const auto& [from, to] : rim_.segments) ++leaving[from], --leaving[to];
    for (const std::vector<std::uint32_t>& vertices : node_to_vertices_)
      for (const std::uint32_t end : vertices)
        for (const std::uint32_t start : vertices) {
          if (leaving[end] >= 0 || leaving[start] <= 0) continue;
          rim_.segments.push_back({end, start});
          rim_.segment_to_edge.emplace_back();
          ++leaving[end], --leaving[start];
        }
  }

  RimMesh mesh(const SizeField& sizes, const std::function<bool()>& keep_going) {
    if (side_.shape.kind != SideKind::Upright)
      return mesh_in_rim(std::move(rim_), *geometry_, points_, sizes, keep_going);
    const SidePlane& plane = side_.shape.plane;
    FaceOverPlane over(*geometry_, {plane.origin, plane.first, plane.second, plane.normal}, rim_, points_, true);
    return mesh_in_rim(std::move(rim_), over, points_, sizes, keep_going);
  }

  // Tops at which pieces of the rim cross; all of them where none is known.
  void find_in_the_way(std::span<const std::uint32_t> crossing) {
    for (const std::uint32_t node : crossing)
      if (result_.nodes[node].curve != kNone) result_.in_the_way.push_back(result_.nodes[node].curve);
    sort_unique(result_.in_the_way);
    if (!result_.in_the_way.empty()) return;
    std::ranges::copy_if(side_.curves, std::back_inserter(result_.in_the_way),
                         [&](std::uint32_t c) { return tops_[c].grows; });
  }

  const SideFaces& sides_;
  const SideFace& side_;
  std::span<const CurveTop> tops_;
  std::unique_ptr<FaceGeometry> geometry_;
  SidePlacer placer_;
  SideMesh result_;
  FaceRim rim_;
  std::vector<Vec3> points_;                                        // per node
  std::vector<std::vector<std::uint32_t>> node_to_vertices_;        // of the rim
  std::unordered_map<std::uint32_t, std::uint32_t> vert_to_curve_;  // looked up only
  std::unordered_map<std::uint64_t, std::uint32_t> nodes_;          // looked up only
};

}  // namespace

SideMesh mesh_rest(const SideFaces& sides, std::size_t side, std::span<const CurveTop> tops, const SizeField& sizes,
                   const std::function<bool()>& keep_going) {
  return RestMesher(sides, side, tops).run(sizes, keep_going);
}

}  // namespace tetloom::layers

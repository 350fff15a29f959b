#include "core/discrete/segmentation.hpp"

#include <algorithm>
#include <cmath>

#include "core/discrete/creases.hpp"
#include "core/discrete/pinched_points.hpp"

namespace tetloom::detail {
namespace {

/// Links the walls into model edges.
class ChainTracer {
 public:
  ChainTracer(const FacetSurface& surface, const std::vector<bool>& walls, std::span<const std::uint32_t> pinched,
              double feature_angle, Segmentation& result)
      : surface_(surface), least_cosine_(std::cos(feature_angle)), result_(result) {
    for (std::uint32_t edge = 0; edge < surface.edges.size(); ++edge) {
      if (walls[edge]) rims_.push_back(edge);
    }
    collect_incidence();
    find_breaks();
    for (const std::uint32_t v : pinched) is_break_[v] = true;
  }

  void run() {
    result_.edge_to_model_edge.assign(surface_.edges.size(), kNone);
    for (const std::uint32_t edge : rims_) {
      if (result_.edge_to_model_edge[edge] == kNone) trace(edge);
    }
    result_.vert_to_model_vert.assign(surface_.points.size(), kNone);
    for (std::uint32_t v = 0; v < surface_.points.size(); ++v) {
      if (!is_break_[v]) continue;
      result_.vert_to_model_vert[v] = static_cast<std::uint32_t>(result_.model_vert_to_vert.size());
      result_.model_vert_to_vert.push_back(v);
    }
  }

 private:
  std::span<const std::uint32_t> rims_at(std::uint32_t v) const {
    return std::span(vert_to_rim_).subspan(offset_[v], offset_[v + 1] - offset_[v]);
  }
  std::uint32_t other_end(std::uint32_t edge, std::uint32_t v) const {
    const auto& ends = surface_.edges.edge_to_vert[edge];
    return ends[0] == v ? ends[1] : ends[0];
  }

  void collect_incidence() {
    offset_.assign(surface_.points.size() + 1, 0);
    for (const std::uint32_t edge : rims_) {
      for (const std::uint32_t v : surface_.edges.edge_to_vert[edge]) ++offset_[v + 1];
    }
    for (std::size_t v = 0; v + 1 < offset_.size(); ++v) offset_[v + 1] += offset_[v];
    vert_to_rim_.resize(offset_.back());
    std::vector<std::uint32_t> fill(offset_.begin(), offset_.end() - 1);
    for (const std::uint32_t edge : rims_) {
      for (const std::uint32_t v : surface_.edges.edge_to_vert[edge]) vert_to_rim_[fill[v]++] = edge;
    }
  }

  std::vector<std::uint32_t> faces_at(std::uint32_t edge) const {
    std::vector<std::uint32_t> faces;
    for (const std::uint32_t half : surface_.edges.halves(edge))
      faces.push_back(result_.tri_to_face[half_to_tri(half)]);
    std::sort(faces.begin(), faces.end());
    return faces;
  }

  bool turns_sharply(std::uint32_t v, std::uint32_t a, std::uint32_t b) const {
    const Vec3 in = normalized(surface_.points[v] - surface_.points[other_end(a, v)]);
    const Vec3 out = normalized(surface_.points[other_end(b, v)] - surface_.points[v]);
    return dot(in, out) < least_cosine_;
  }

  void find_breaks() {
    is_break_.assign(surface_.points.size(), false);
    for (std::uint32_t v = 0; v < surface_.points.size(); ++v) {
      const auto rims = rims_at(v);
      if (rims.empty()) continue;
      is_break_[v] = rims.size() != 2 || turns_sharply(v, rims[0], rims[1]) || faces_at(rims[0]) != faces_at(rims[1]);
    }
  }

  /// Walks from `v` away from `edge` to the next break, or back to the other end of `first`; appends the points passed.
  void walk(std::uint32_t edge, std::uint32_t v, std::vector<std::uint32_t>& verts,
            std::vector<std::uint32_t>& edges) const {
    const std::uint32_t first = edge;
    while (true) {
      verts.push_back(v);
      if (is_break_[v]) return;
      const auto rims = rims_at(v);
      edge = rims[0] == edge ? rims[1] : rims[0];
      if (edge == first) return;
      edges.push_back(edge);
      v = other_end(edge, v);
    }
  }

  void trace(std::uint32_t edge) {
    const auto [low, high] = surface_.edges.edge_to_vert[edge];
    std::vector<std::uint32_t> verts, edges{edge}, ahead;
    walk(edge, low, verts, edges);
    std::reverse(verts.begin(), verts.end());
    const bool closed_without_break = !is_break_[verts.front()];
    if (closed_without_break) {
      std::rotate(verts.begin(), std::min_element(verts.begin(), verts.end()), verts.end());
      verts.push_back(verts.front());
      is_break_[verts.front()] = true;
    } else {
      walk(edge, high, ahead, edges);
      verts.insert(verts.end(), ahead.begin(), ahead.end());
    }
    for (const std::uint32_t e : edges) {
      result_.edge_to_model_edge[e] = static_cast<std::uint32_t>(result_.model_edge_to_verts.size());
    }
    result_.model_edge_to_verts.push_back(std::move(verts));
  }

  const FacetSurface& surface_;
  double least_cosine_;
  Segmentation& result_;
  std::vector<std::uint32_t> rims_, offset_, vert_to_rim_;
  std::vector<bool> is_break_;
};

/// Walks along the rims of faces and names the model edges passed.
class LoopTracer {
 public:
  LoopTracer(const FacetSurface& surface, Segmentation& result)
      : surface_(surface), result_(result), visited_(surface.edges.half_to_edge.size(), false) {}

  void run() {
    result_.face_to_loops.resize(result_.face_count);
    for (std::uint32_t half = 0; half < visited_.size(); ++half) {
      // Loops start at model vertices; every rim passes one.
      if (visited_[half] || !starts_edge(half)) continue;
      result_.face_to_loops[result_.tri_to_face[half_to_tri(half)]].push_back(trace(half));
    }
    mark_second_sides();
  }

 private:
  bool starts_edge(std::uint32_t half) const {
    return result_.edge_to_model_edge[surface_.edges.half_to_edge[half]] != kNone &&
           result_.vert_to_model_vert[surface_.origin(half)] != kNone;
  }

  /// Whether the half-edge, which begins its model edge or ends it, runs along it.
  bool runs_forward(std::uint32_t half, std::uint32_t model_edge) const {
    const auto& verts = result_.model_edge_to_verts[model_edge];
    return verts[0] == surface_.origin(half) && verts[1] == surface_.head(half);
  }

  ModelLoop trace(std::uint32_t start) {
    ModelLoop loop;
    std::uint32_t half = start;
    do {
      visited_[half] = true;
      if (starts_edge(half)) {
        const std::uint32_t model_edge = result_.edge_to_model_edge[surface_.edges.half_to_edge[half]];
        loop.push_back({ModelEdgeId(model_edge), runs_forward(half, model_edge), false});
      }
      half = next_rim_half(surface_, result_, half);
    } while (half != start);
    return loop;
  }

  void mark_second_sides() {
    std::vector<std::uint32_t> last_face(result_.model_edge_to_verts.size(), kNone);
    for (std::uint32_t face = 0; face < result_.face_count; ++face) {
      for (ModelLoop& loop : result_.face_to_loops[face]) {
        for (EdgeUse& use : loop) {
          use.second_side = last_face[use.edge.value] == face;
          last_face[use.edge.value] = face;
        }
      }
    }
  }

  const FacetSurface& surface_;
  Segmentation& result_;
  std::vector<bool> visited_;
};

}  // namespace

std::uint32_t next_rim_half(const FacetSurface& surface, const Segmentation& segmentation, std::uint32_t half) {
  std::uint32_t next = next_half(half);
  while (segmentation.edge_to_model_edge[surface.edges.half_to_edge[next]] == kNone) {
    next = next_half(surface.edges.twin(next));
  }
  return next;
}

Segmentation segment_surface(const FacetSurface& surface, double feature_angle) {
  Segmentation result;
  std::vector<bool> walls = find_walls(surface, feature_angle);
  const std::vector<std::uint32_t> pinched = find_pinched_points(surface);
  add_walls_at(pinched, surface, walls);
  result.tri_to_face = flood_between_walls(surface, walls, result.face_count);
  ChainTracer(surface, walls, pinched, feature_angle, result).run();
  LoopTracer(surface, result).run();
  return result;
}

}  // namespace tetloom::detail

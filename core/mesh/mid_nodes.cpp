#include "core/mesh/mid_nodes.hpp"

#include <atomic>

#include "core/base/grain.hpp"
#include "core/base/grouping.hpp"
#include "core/base/lists.hpp"

namespace tetloom {
namespace {

using Edge = std::array<std::uint32_t, 2>;

// The edges of vertices, each under its lower end.
class EdgesByVertex {
 public:
  EdgesByVertex(const Mesh& mesh, const BlockLoop& loop) : vertices_(vertex_count(mesh)), loop_(loop) {
    highs_ = Grouping(vertices_, [&](const auto& file) {
      for_each_edge_owner(mesh, [&](const auto& elements, std::span<const LocalEdge> edges) {
        loop.for_blocks(elements.size(), kCopyGrain, [&](std::size_t begin, std::size_t end) {
          for (std::size_t e = begin; e < end; ++e)
            for (const auto& [a, b] : edges) {
              const auto [low, high] = std::minmax(elements[e][a], elements[e][b]);
              file(high, low);
            }
        });
      });
    });
  }

  std::vector<Edge> take_unique() {
    std::vector<std::uint32_t> begins(vertices_ + 1, 0);
    for_vertices([&](std::uint32_t low, std::span<const std::uint32_t> highs) {
      begins[low + 1] = static_cast<std::uint32_t>(highs.size());
    });
    for (std::size_t v = 0; v < vertices_; ++v) begins[v + 1] += begins[v];
    std::vector<Edge> edges(begins.back());
    for_vertices([&](std::uint32_t low, std::span<const std::uint32_t> highs) {
      for (std::size_t i = 0; i < highs.size(); ++i) edges[begins[low] + i] = {low, highs[i]};
    });
    return edges;
  }

 private:
  // Calls body(low, highs), each of them once and ascending.
  template <class Body>
  void for_vertices(const Body& body) const {
    loop_.for_blocks(vertices_, kCopyGrain, [&](std::size_t begin, std::size_t end) {
      std::vector<std::uint32_t> highs;
      for (std::size_t v = begin; v < end; ++v) {
        highs.assign(highs_[v].begin(), highs_[v].end());
        sort_unique(highs);
        body(static_cast<std::uint32_t>(v), std::span<const std::uint32_t>(highs));
      }
    });
  }

  std::size_t vertices_;
  const BlockLoop& loop_;
  Grouping highs_;
};

// For several threads at once. Carries no data, so relaxed order is enough.
void lower_to(std::uint32_t& value, std::uint32_t other) {
  const std::atomic_ref shared(value);
  std::uint32_t known = shared.load(std::memory_order_relaxed);
  while (other < known && !shared.compare_exchange_weak(known, other, std::memory_order_relaxed)) {}
}

bool is_ascending(std::span<const Edge> edges, std::size_t vertices) {
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (edges[i][0] >= edges[i][1] || edges[i][1] >= vertices) return false;
    if (i > 0 && edges[i] <= edges[i - 1]) return false;
  }
  return true;
}

// Whether all edges of the elements from `begin` to `end` have mid nodes. Most edges belong to several elements.
template <class Element>
bool have_mid_nodes(std::span<const Element> elements, std::span<const LocalEdge> edges, const MidNodes& mids) {
  return std::ranges::all_of(elements, [&](const Element& v) {
    return std::ranges::all_of(edges, [&](const LocalEdge& e) { return mids.find(v[e[0]], v[e[1]]) != kNone; });
  });
}

// Whether all cells lie in one region, and which; nothing without cells.
std::optional<std::uint32_t> only_region_of(const Mesh& mesh) {
  std::optional<std::uint32_t> region;
  bool is_only = true;
  for_each_cell_kind(mesh, [&](CellKind, const auto& cells, const auto& regions) {
    if (cells.empty()) return;
    if (!region) region = regions.front();
    is_only &= std::ranges::all_of(regions, [&](std::uint32_t r) { return r == *region; });
  });
  return is_only ? region : std::nullopt;
}

// Every mid node into the lowest of the regions of its cells, or into none. In a mesh of one region those of edges that
// no cell has get it too; such an edge belongs to an element that has the last word.
void put_into_regions(const Mesh& mesh, const MidNodes& mids, std::span<ModelEntity> entities, const BlockLoop& loop) {
  if (const std::optional<std::uint32_t> region = only_region_of(mesh)) {
    std::ranges::fill(entities, ModelEntity{3, *region});
    return;
  }
  for_each_cell_kind(mesh, [&](CellKind kind, const auto& cells, const auto& regions) {
    loop.for_blocks(cells.size(), kCopyGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t c = begin; c < end; ++c)
        for (const auto& [a, b] : shape_of(kind).edges())
          lower_to(entities[mids.find(cells[c][a], cells[c][b])].index, regions[c]);
    });
  });
  for (ModelEntity& entity : entities) entity = {3, entity.index};
}

}  // namespace

std::vector<Edge> edges_of_elements(const Mesh& mesh, const BlockLoop& loop) {
  return EdgesByVertex(mesh, loop).take_unique();
}

MidNodes::MidNodes(const Mesh& mesh)
    : edges_(mesh.mid_to_vert), vertices_(static_cast<std::uint32_t>(vertex_count(mesh))) {
  if (edges_.empty()) return;
  begins_.resize(vertices_ + std::size_t{1}, 0);
  for (const Edge& edge : edges_) ++begins_[edge[0] + 1];
  for (std::size_t v = 0; v < vertices_; ++v) begins_[v + 1] += begins_[v];
}

CellMids::CellMids(CellKind kind, std::span<const std::uint32_t> verts, const MidNodes& mids) {
  for (const auto& [a, b] : shape_of(kind).edges()) mids_[count_++] = mids.find(verts[a], verts[b]);
}

std::vector<std::uint8_t> ends_of_bent_edges(const Mesh& mesh) {
  const std::size_t vertices = vertex_count(mesh);
  std::vector<std::uint8_t> is_end(vertices, 0);
  for (std::size_t m = 0; m < mesh.mid_to_vert.size(); ++m)
    if (mesh.points[vertices + m] != middle_of_edge(mesh, m))
      for (const std::uint32_t v : mesh.mid_to_vert[m]) is_end[v] = 1;
  return is_end;
}

std::optional<std::string> find_mid_node_fault(const Mesh& mesh, const BlockLoop& loop) {
  const std::size_t mid_nodes = mesh.mid_to_vert.size(), points = mesh.points.size();
  if (mid_nodes == 0) return {};
  if (mid_nodes > points)
    return std::to_string(mid_nodes) + " mid nodes are more than the " + std::to_string(points) + " points";
  if (!is_ascending(mesh.mid_to_vert, vertex_count(mesh)))
    return "the ends of mid nodes are no vertices, or not in ascending order";
  const MidNodes mids(mesh);
  bool fits = true;
  for_each_edge_owner(mesh, [&](const auto& elements, std::span<const LocalEdge> edges) {
    const auto check = [&](std::size_t begin, std::size_t end, std::uint8_t& is_fine) {
      is_fine = have_mid_nodes(std::span(elements).subspan(begin, end - begin), edges, mids) ? 1 : 0;
    };
    for (const std::uint8_t is_fine : map_blocks(loop, elements.size(), kCopyGrain, std::uint8_t{1}, check))
      fits &= is_fine != 0;
  });
  if (!fits) return "an edge of an element has no mid node although others have";
  return {};
}

void classify_mid_nodes(Mesh& mesh, const BlockLoop& loop) {
  const MidNodes mids(mesh);
  const std::span<ModelEntity> entities = std::span(mesh.point_to_entity).subspan(vertex_count(mesh));
  put_into_regions(mesh, mids, entities, loop);
  const auto classify = [&](const auto& elements, const auto& owners, std::span<const LocalEdge> edges, int dim) {
    for (std::size_t e = elements.size(); e-- > 0;)  // the first element has the last word
      for (const auto& [a, b] : edges) entities[mids.find(elements[e][a], elements[e][b])] = {dim, owners[e]};
  };
  classify(mesh.quad_to_vert, mesh.quad_to_entity, kQuadEdges, 2);
  classify(mesh.tri_to_vert, mesh.tri_to_entity, kTriangleEdges, 2);
  classify(mesh.edge_to_vert, mesh.edge_to_entity, kLineEdges, 1);
  for (ModelEntity& entity : entities)
    if (!entity.valid()) entity = {};
}

void drop_mid_nodes(Mesh& mesh) {
  const std::size_t vertices = vertex_count(mesh);
  mesh.points.resize(vertices);
  if (!mesh.point_to_entity.empty()) mesh.point_to_entity.resize(vertices);
  for (MeshField& field : mesh.point_fields)
    field.values.resize(vertices * static_cast<std::size_t>(std::max(field.components, 0)));
  mesh.mid_to_vert.clear();
}

}  // namespace tetloom

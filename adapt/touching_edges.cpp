#include "adapt/touching_edges.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <queue>
#include <utility>
#include <vector>

#include "adapt/kernel/cavity_mesh.hpp"
#include "core/base/lists.hpp"
#include "core/geometry/model_projector.hpp"
#include "core/predicates/predicates.hpp"

namespace tetloom::adapt {

namespace {

constexpr double kLongest = 1.4142135623730951;

using EdgeVerts = std::array<std::uint32_t, 2>;

/// Edges of more than three triangles, ascending: umbrellas that touch have two each.
std::vector<EdgeVerts> find_candidates(const Mesh& mesh) {
  std::vector<EdgeVerts> uses, found;
  uses.reserve(mesh.tri_to_vert.size() * 3);
  for (const auto& v : mesh.tri_to_vert)
    for (std::size_t i = 0; i < 3; ++i) uses.push_back(ascending(v[i], v[(i + 1) % 3]));
  std::sort(uses.begin(), uses.end());
  for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
    for (end = i; end < uses.size() && uses[end] == uses[i];) ++end;
    if (end - i > 3) found.push_back(uses[i]);
  }
  return found;
}

/// How many umbrellas the tets at an edge make, of each of which the two other vertices are known.
std::size_t count_umbrellas(std::vector<EdgeVerts> ring) {
  std::size_t umbrellas = 0;
  for (; !ring.empty(); ++umbrellas) {
    std::vector<std::uint32_t> reached{ring.back()[0]};
    for (std::size_t i = 0; i < reached.size(); ++i)
      std::erase_if(ring, [&](const EdgeVerts& pair) {
        if (!has(pair, reached[i])) return false;
        reached.insert(reached.end(), pair.begin(), pair.end());
        return true;
      });
  }
  return umbrellas;
}

std::vector<EdgeVerts> find_touching_edges(const Mesh& mesh) {
  std::vector<EdgeVerts> edges = find_candidates(mesh);
  if (edges.empty()) return edges;
  std::vector<std::uint8_t> is_end(mesh.points.size(), 0);
  for (const auto& [a, b] : edges) is_end[a] = is_end[b] = 1;
  std::vector<std::vector<EdgeVerts>> rings(edges.size());
  for (const TetVerts& v : mesh.tet_to_vert) {
    for (const auto& [i, j] : tets::kEdgeVerts) {
      if (is_end[v[i]] == 0 || is_end[v[j]] == 0) continue;
      const auto at = std::lower_bound(edges.begin(), edges.end(), ascending(v[i], v[j]));
      if (at == edges.end() || *at != ascending(v[i], v[j])) continue;
      EdgeVerts others{};
      std::size_t count = 0;
      for (std::size_t k = 0; k < 4; ++k)
        if (k != i && k != j) others[count++] = v[k];
      rings[static_cast<std::size_t>(at - edges.begin())].push_back(others);
    }
  }
  std::vector<EdgeVerts> touching;
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (count_umbrellas(std::move(rings[i])) > 1) touching.push_back(edges[i]);
  return touching;
}

/// The simplices of one kind at the ends of the edges that are split.
template <std::size_t N>
struct Simplices {
  using Verts = std::array<std::uint32_t, N>;

  Simplices(std::vector<Verts>& all, std::vector<std::uint32_t>& all_entities)
      : to_vert(all), to_entity(all_entities) {}

  void add(std::uint32_t number) {
    for (const std::uint32_t v : to_vert[number])
      if (const auto at = of_vert.find(v); at != of_vert.end()) at->second.push_back(number);
  }

  std::vector<std::uint32_t> at_edge(std::uint32_t a, std::uint32_t b) const {
    std::vector<std::uint32_t> numbers = of_vert.at(a);
    std::erase_if(numbers, [&](std::uint32_t number) { return !has(to_vert[number], b); });
    return numbers;
  }

  /// The one that has a keeps its number.
  void split(std::uint32_t number, std::uint32_t a, std::uint32_t b, std::uint32_t middle) {
    Verts behind = to_vert[number];
    std::replace(behind.begin(), behind.end(), a, middle);
    std::replace(to_vert[number].begin(), to_vert[number].end(), b, middle);
    std::erase(of_vert[b], number);
    of_vert[middle].push_back(number);
    to_vert.push_back(behind), to_entity.push_back(std::uint32_t{to_entity[number]});
    add(static_cast<std::uint32_t>(to_vert.size() - 1));
  }

  std::vector<Verts>& to_vert;
  std::vector<std::uint32_t>& to_entity;
  std::map<std::uint32_t, std::vector<std::uint32_t>> of_vert;
};

class Splitter {
 public:
  Splitter(const Mesh& mesh, const MetricField& metric, const MetricFunction& function, const GeometricModel* model)
      : result_{mesh, metric},
        function_(function),
        tets_(mesh_.tet_to_vert, mesh_.tet_to_entity),
        triangles_(mesh_.tri_to_vert, mesh_.tri_to_entity) {
    if (model) project_ = make_projector(*model);
  }

  std::optional<RefinedInput> run(const std::vector<EdgeVerts>& edges, std::size_t most_tets) {
    const std::size_t given = mesh_.points.size();
    for (const auto& [a, b] : edges) ask(a, b);
    if (queue_.empty()) return std::nullopt;
    start(edges);
    while (!queue_.empty() && mesh_.tet_to_vert.size() < most_tets) {
      const auto [a, b] = queue_.top().second;
      queue_.pop();
      split(a, b);
    }
    if (mesh_.points.size() == given) return std::nullopt;
    return std::move(result_);
  }

 private:
  void ask(std::uint32_t a, std::uint32_t b) {
    const double length = edge_length(result_.metric.at(a), result_.metric.at(b), mesh_.points[b] - mesh_.points[a]);
    if (length > kLongest) queue_.emplace(length, ascending(a, b));
  }

  void start(const std::vector<EdgeVerts>& edges) {
    for (const auto& edge : edges)
      for (const std::uint32_t v : edge) tets_.of_vert[v], triangles_.of_vert[v];
    for (std::uint32_t i = 0; i < mesh_.tet_to_vert.size(); ++i) tets_.add(i);
    for (std::uint32_t i = 0; i < mesh_.tri_to_vert.size(); ++i) triangles_.add(i);
    for (std::uint32_t i = 0; i < mesh_.edge_to_vert.size(); ++i) {
      const auto [a, b] = mesh_.edge_to_vert[i];
      if (std::binary_search(edges.begin(), edges.end(), ascending(a, b))) pieces_[ascending(a, b)] = i;
    }
  }

  void split(std::uint32_t a, std::uint32_t b) {
    const Vec3 e = mesh_.points[b] - mesh_.points[a];
    const Tensor ma = result_.metric.at(a), mb = result_.metric.at(b);
    const double pieces = std::max(2.0, std::round(edge_length(ma, mb, e)));
    const double share = place_on_edge(std::sqrt(dot(ma, e)), std::sqrt(dot(mb, e)), std::floor(pieces / 2) / pieces);
    const std::vector<std::uint32_t> tets = tets_.at_edge(a, b);
    const std::optional<Vec3> place = find_place(a, b, share, tets);
    if (!place) return;
    const std::uint32_t middle = add_point(a, b, share, *place);
    for (const std::uint32_t tet : tets) {
      tets_.split(tet, a, b, middle);
      for (MeshField& field : mesh_.cell_fields) {
        const auto count = static_cast<std::size_t>(field.components);
        for (std::size_t i = 0; i < count; ++i) field.values.push_back(double{field.values[tet * count + i]});
      }
    }
    for (const std::uint32_t triangle : triangles_.at_edge(a, b)) triangles_.split(triangle, a, b, middle);
    split_piece(a, b, middle);
    ask(a, middle), ask(middle, b);
  }

  std::uint32_t add_point(std::uint32_t a, std::uint32_t b, double share, const Vec3& place) {
    const auto middle = static_cast<std::uint32_t>(mesh_.points.size());
    mesh_.points.push_back(place);
    if (!mesh_.point_to_entity.empty()) mesh_.point_to_entity.emplace_back();
    const std::vector<Tensor>& logs = result_.metric.logs;
    result_.metric.logs.push_back(function_ ? log(function_(mesh_.points.back()))
                                            : (1 - share) * logs[a] + share * logs[b]);
    for (MeshField& field : mesh_.point_fields) {
      const auto count = static_cast<std::size_t>(field.components);
      for (std::size_t i = 0; i < count; ++i)
        field.values.push_back((1 - share) * field.values[a * count + i] + share * field.values[b * count + i]);
    }
    tets_.of_vert[middle], triangles_.of_vert[middle];
    return middle;
  }

  // Where the edge is split: on the model, or else on the straight edge. Nothing where even there rounding would leave
  // a flat or inverted tet.
  std::optional<Vec3> find_place(std::uint32_t a, std::uint32_t b, double share,
                                 std::span<const std::uint32_t> tets) const {
    const Vec3 straight = mesh_.points[a] + share * (mesh_.points[b] - mesh_.points[a]);
    const std::optional<Vec3> snapped = place_on_model(a, b, straight);
    if (snapped && keeps_sides(a, b, *snapped, tets)) return snapped;
    return keeps_sides(a, b, straight, tets) ? std::optional(straight) : std::nullopt;
  }

  std::optional<Vec3> place_on_model(std::uint32_t a, std::uint32_t b, const Vec3& straight) const {
    const auto piece = pieces_.find(ascending(a, b));
    if (!project_ || piece == pieces_.end() || mesh_.edge_to_entity[piece->second] == kNone) return {};
    const auto spot = project_(ModelEntity(1, mesh_.edge_to_entity[piece->second]), straight);
    if (!spot || norm2(spot->point - straight) > 0.25 * norm2(mesh_.points[b] - mesh_.points[a])) return {};
    return spot->point;
  }

  // Whether the tets that a split makes turn as those at the edge do, exactly.
  bool keeps_sides(std::uint32_t a, std::uint32_t b, const Vec3& place, std::span<const std::uint32_t> tets) const {
    for (const std::uint32_t tet : tets) {
      const int side = side_of(tet, kNone, place);
      if (side_of(tet, a, place) != side || side_of(tet, b, place) != side) return false;
    }
    return true;
  }

  // orient3d of a tet with `place` in the place of a vertex.
  int side_of(std::uint32_t tet, std::uint32_t vert, const Vec3& place) const {
    const auto at = [&](std::size_t i) {
      const std::uint32_t v = mesh_.tet_to_vert[tet][i];
      return v == vert ? place : mesh_.points[v];
    };
    return orient3d(at(0), at(1), at(2), at(3));
  }

  void split_piece(std::uint32_t a, std::uint32_t b, std::uint32_t middle) {
    const auto at = pieces_.find(ascending(a, b));
    if (at == pieces_.end()) return;
    const std::uint32_t piece = at->second;
    pieces_.erase(at);
    pieces_[ascending(a, middle)] = piece;
    pieces_[ascending(b, middle)] = static_cast<std::uint32_t>(mesh_.edge_to_vert.size());
    mesh_.edge_to_vert[piece] = {a, middle};
    mesh_.edge_to_vert.push_back({middle, b});
    mesh_.edge_to_entity.push_back(std::uint32_t{mesh_.edge_to_entity[piece]});
  }

  RefinedInput result_;
  Mesh& mesh_ = result_.mesh;
  const MetricFunction& function_;
  SurfaceProjector project_;
  Simplices<4> tets_;
  Simplices<3> triangles_;
  std::map<EdgeVerts, std::uint32_t> pieces_;                // pieces of model edges, by their ends
  std::priority_queue<std::pair<double, EdgeVerts>> queue_;  // by length
};

}  // namespace

bool has_touching_edges(const Mesh& mesh, const std::vector<std::uint8_t>& is_own) {
  return std::ranges::any_of(find_touching_edges(mesh),
                             [&](const EdgeVerts& edge) { return is_own[edge[0]] != 0 || is_own[edge[1]] != 0; });
}

std::optional<RefinedInput> split_touching_edges(const Mesh& mesh, const MetricField& metric,
                                                 const MetricFunction& function, const GeometricModel* model,
                                                 std::size_t most_tets) {
  const std::vector<EdgeVerts> edges = find_touching_edges(mesh);
  if (edges.empty()) return std::nullopt;
  return Splitter(mesh, metric, function, model).run(edges, most_tets);
}

}  // namespace tetloom::adapt

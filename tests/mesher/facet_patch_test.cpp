// The starting triangulation of faces remeshed in space: its rim is the nodes, whatever the tessellation.
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <random>
#include <set>

#include "mesher/surface/facet_patch.hpp"
#include "mesher/surface/facet_patch_detail.hpp"
#include "tests/core/discrete_shapes.hpp"
#include "tests/support/analytic_model.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;

namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// Nodes for every edge of a model: its vertices, then pieces of random or even length.
class Nodes {
 public:
  /// `pieces(edge)` is asked per edge. `jitter` in 0 … 1 makes the pieces uneven.
  template <class Pieces>
  Nodes(const GeometricModel& model, std::mt19937& random, double jitter, Pieces&& pieces) : model_(model) {
    const ModelTopology& topology = model.topology();
    auto next = static_cast<std::uint32_t>(topology.vertex_count);
    std::uniform_real_distribution<double> shift(-0.45 * jitter, 0.45 * jitter);
    for (std::size_t edge = 0; edge < topology.edge_count(); ++edge) {
      const auto& ends = topology.edges[edge].vertices;
      std::vector<BoundaryNode> nodes;
      const Vec3 first = model.vertex_point(ends[0]), last = model.vertex_point(ends[1]);
      if (topology.edges[edge].degenerate) {
        nodes = {{ends[0].value, 0, first}, {ends[1].value, 1, last}};
      } else {
        const auto geometry = model.edge_geometry(ModelEdgeId(edge));
        const ParameterRange range = geometry->range();
        const int count = std::max(pieces(ModelEdgeId(edge)), ends[0] == ends[1] ? 3 : 1);
        nodes.push_back({ends[0].value, range.lo, first});
        for (int i = 1; i < count; ++i) {
          const double t = range.lo + (range.hi - range.lo) * (i + shift(random)) / count;
          nodes.push_back({next++, t, geometry->evaluate(t)});
        }
        nodes.push_back({ends[1].value, range.hi, last});
      }
      edge_to_nodes_.push_back(std::move(nodes));
    }
  }

  std::vector<BoundaryChain> chains(ModelFaceId face) const {
    std::vector<BoundaryChain> result;
    for (const ModelLoop& loop : model_.topology().face_to_loops[face.value]) {
      for (const EdgeUse& use : loop) {
        result.push_back({use, model_.topology().edges[use.edge.value].vertices, edge_to_nodes_[use.edge.value]});
      }
    }
    return result;
  }

 private:
  const GeometricModel& model_;
  std::vector<std::vector<BoundaryNode>> edge_to_nodes_;
};

std::map<Edge, int> half_edges_of(const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::map<Edge, int> halves;
  for (const auto& t : triangles) {
    for (int i = 0; i < 3; ++i) ++halves[{t[i], t[(i + 1) % 3]}];
  }
  return halves;
}

/// Vertices in use - edges + triangles.
long euler_of(const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::set<Edge> edges;
  std::set<std::uint32_t> vertices;
  for (const auto& [half, count] : half_edges_of(triangles)) {
    edges.insert(std::minmax(half.first, half.second));
    vertices.insert(half.first);
  }
  return static_cast<long>(vertices.size()) - static_cast<long>(edges.size()) + static_cast<long>(triangles.size());
}

/// The directed pieces between nodes that the chains ask for.
std::multiset<Edge> pieces_of(const std::vector<BoundaryChain>& chains) {
  std::multiset<Edge> pieces;
  for (const BoundaryChain& chain : chains) {
    for (std::size_t i = 0; i + 1 < chain.nodes.size(); ++i) {
      const Edge piece{chain.nodes[i].node, chain.nodes[i + 1].node};
      if (piece.first == piece.second) continue;  // a pole
      pieces.insert(chain.use.forward ? piece : Edge{piece.second, piece.first});
    }
  }
  return pieces;
}

/// Everything that is promised of an Ok patch.
void check_patch(const FacetPatch& patch, FaceGeometry& face, const std::vector<BoundaryChain>& chains, long euler) {
  REQUIRE(patch.verdict == FacetPatchVerdict::Ok);
  REQUIRE(patch.uv.size() == patch.points.size());
  REQUIRE(patch.node.size() == patch.points.size());
  std::multiset<Edge> rim;
  std::size_t crowded = 0, off_node = 0;
  const auto halves = half_edges_of(patch.tri_to_vert);
  for (const auto& [half, count] : halves) {
    crowded += count != 1;
    if (halves.count({half.second, half.first})) continue;
    off_node += patch.node[half.first] == FacetPatch::kNoNode || patch.node[half.second] == FacetPatch::kNoNode;
    rim.insert({patch.node[half.first], patch.node[half.second]});
  }
  CHECK(crowded == 0);
  CHECK(off_node == 0);
  CHECK(rim == pieces_of(chains));
  CHECK(euler_of(patch.tri_to_vert) == euler);
  std::map<std::uint32_t, Vec3> place;
  for (const BoundaryChain& chain : chains) {
    for (const BoundaryNode& node : chain.nodes) place[node.node] = node.point;
  }
  std::size_t misplaced = 0, inverted = 0;
  for (std::size_t v = 0; v < patch.points.size(); ++v) {
    if (patch.node[v] != FacetPatch::kNoNode) misplaced += !(place.at(patch.node[v]) == patch.points[v]);
  }
  for (const auto& [a, b, c] : patch.tri_to_vert) {
    const Vec3 n = cross(patch.points[b] - patch.points[a], patch.points[c] - patch.points[a]);
    Vec3 mean;
    for (const std::uint32_t v : {a, b, c}) {
      mean += face.normal(face.closest_point(patch.points[v], patch.uv[v]).uv);
    }
    inverted += !(dot(n, mean) > 0);
  }
  CHECK(misplaced == 0);
  CHECK(inverted == 0);
}

/// Patches of all faces of a model whose facets have the Euler characteristics given.
void check_model(const GeometricModel& model, const Nodes& nodes, const std::vector<long>& euler, double chord,
                 double angle) {
  REQUIRE(model.topology().face_count() == euler.size());
  for (std::size_t i = 0; i < euler.size(); ++i) {
    INFO("face " << i);
    const auto face = model.face_geometry(ModelFaceId(i));
    const auto chains = nodes.chains(ModelFaceId(i));
    const FacetPatch patch = make_facet_patch(face->tessellate(chord, angle), chains);
    CAPTURE(patch.trouble.x, patch.trouble.y, patch.trouble.z);
    check_patch(patch, *face, chains, euler[i]);
  }
}

std::unique_ptr<GeometricModel> discrete(const shapes::Facets& facets) {
  return make_discrete_model(facets.points, facets.triangles, 1.3);
}

shapes::Facets disc(std::uint32_t columns, std::uint32_t rings, double bulge) {
  shapes::Facets facets;
  facets.points.push_back({0, 0, bulge});
  for (std::uint32_t j = 1; j <= rings; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      const double a = 2 * M_PI * i / columns, s = 1.0 * j / rings;
      facets.points.push_back(bulge > 0 ? Vec3{std::sin(s * M_PI / 2) * std::cos(a),
                                               std::sin(s * M_PI / 2) * std::sin(a), bulge * std::cos(s * M_PI / 2)}
                                        : Vec3{s * std::cos(a), s * std::sin(a), 0});
    }
  }
  for (std::uint32_t i = 0; i < columns; ++i) facets.triangles.push_back({0, 1 + i, 1 + (i + 1) % columns});
  for (std::uint32_t j = 1; j < rings; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      const std::uint32_t p = 1 + (j - 1) * columns + i, q = 1 + (j - 1) * columns + (i + 1) % columns;
      facets.triangles.push_back({p, p + columns, q + columns});
      facets.triangles.push_back({p, q + columns, q});
    }
  }
  return facets;
}

}  // namespace

TEST_CASE("the rim of a disc, flat or a hemisphere, becomes the nodes, finer or coarser than the facets") {
  const unsigned seed = GENERATE(range(1u, 41u));
  INFO("seed " << seed);
  std::mt19937 random(seed);
  const auto columns = static_cast<std::uint32_t>(6 + random() % 60),
             rings = static_cast<std::uint32_t>(1 + random() % 20);
  const int pieces = 4 + static_cast<int>(random() % 80);
  CAPTURE(columns, rings, pieces);
  const auto model = discrete(disc(columns, rings, seed % 2));
  const Nodes nodes(*model, random, seed % 3 ? 1 : 0, [&](ModelEdgeId) { return pieces; });
  check_model(*model, nodes, {1}, 1, 1);
}

TEST_CASE("a very fine disc takes a rim of four nodes, and a coarse one a rim of a thousand") {
  std::mt19937 random(1);
  const auto fine = discrete(disc(800, 60, 0)), coarse = discrete(disc(7, 1, 0));
  check_model(*fine, Nodes(*fine, random, 0, [](ModelEdgeId) { return 4; }), {1}, 1, 1);
  check_model(*coarse, Nodes(*coarse, random, 1, [](ModelEdgeId) { return 1000; }), {1}, 1, 1);
}

TEST_CASE("an annulus and a cylinder keep both of their rims, whatever the two densities") {
  const unsigned seed = GENERATE(range(1u, 41u));
  INFO("seed " << seed);
  std::mt19937 random(seed);
  const auto columns = static_cast<std::uint32_t>(9 + random() % 60),
             rows = static_cast<std::uint32_t>(1 + random() % 20);
  const int first = 5 + static_cast<int>(random() % 60), second = 5 + static_cast<int>(random() % 60);
  CAPTURE(columns, rows, first, second);
  const bool flat = seed % 2;
  const auto facets = shapes::make_grid(columns, rows, false, [&](std::uint32_t i, std::uint32_t j) {
    const double a = -2 * M_PI * i / columns, s = 1.0 * j / rows;
    return flat ? Vec3{(1 + s) * std::cos(a), (1 + s) * std::sin(a), 0} : Vec3{std::cos(a), std::sin(a), 2 * s};
  });
  const auto model = discrete(facets);
  const Nodes nodes(*model, random, seed % 3 ? 1 : 0,
                    [&](ModelEdgeId edge) { return edge.value == 0 ? first : second; });
  check_model(*model, nodes, {0}, 1, 1);
}

TEST_CASE("faces with seams and poles keep both sides of the seam and one point at a pole") {
  const unsigned seed = GENERATE(range(1u, 16u));
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> angle(0.1, 0.6);
  const double fineness = angle(random), jitter = seed % 3 ? 0.8 : 0;
  const auto pieces = [&](ModelEdgeId) { return 8 + static_cast<int>(random() % 30); };
  const auto sphere = test_models::make_sphere({1, 2, 3}, 2);
  check_model(*sphere, Nodes(*sphere, random, jitter, pieces), {1}, 10, fineness);
  const auto cylinder = test_models::make_cylinder(1, 3);
  check_model(*cylinder, Nodes(*cylinder, random, jitter, pieces), {1, 1, 1}, 10, fineness);
  const auto cone = test_models::make_cone(1, 2);
  check_model(*cone, Nodes(*cone, random, jitter, pieces), {1, 1}, 10, fineness);
  const auto torus = test_models::make_torus(3, 1);
  check_model(*torus, Nodes(*torus, random, jitter, pieces), {1}, 10, fineness);
  const auto annulus = test_models::make_annulus(1, 2);
  check_model(*annulus, Nodes(*annulus, random, jitter, pieces), {0}, 10, fineness);
}

TEST_CASE("flat faces that consist of their corners alone take any nodes") {
  std::mt19937 random(3);
  const auto box = test_models::make_box({0, 0, 0}, {1, 2, 3});
  for (const int pieces : {1, 2, 7})
    check_model(*box, Nodes(*box, random, 0.5, [&](ModelEdgeId) { return pieces; }), std::vector<long>(6, 1), 1, 1);
}

TEST_CASE("a face without edges comes back as it is") {
  const auto sphere = discrete(shapes::make_sphere({0, 0, 0}, 1, 2));
  const Tessellation t = sphere->face_geometry(ModelFaceId(0))->tessellate(1, 1);
  const FacetPatch patch = make_facet_patch(t, {});
  REQUIRE(patch.verdict == FacetPatchVerdict::Ok);
  CHECK(patch.points == t.points);
  CHECK(patch.tri_to_vert == t.tri_to_vert);
  CHECK(euler_of(patch.tri_to_vert) == 2);
}

TEST_CASE("points inside that nothing forces out are kept") {
  std::mt19937 random(1);
  const auto model = discrete(disc(40, 12, 0));
  const auto face = model->face_geometry(ModelFaceId(0));
  const Tessellation t = face->tessellate(1, 1);
  const Nodes nodes(*model, random, 0, [](ModelEdgeId) { return 40; });
  const FacetPatch patch = make_facet_patch(t, nodes.chains(ModelFaceId(0)));
  CHECK(patch.tri_to_vert.size() == t.tri_to_vert.size());
}

TEST_CASE("chains of another face, or too few of them, disagree") {
  std::mt19937 random(1);
  const auto model = discrete(shapes::make_cylinder(1, 2, 24, 4));
  const Nodes nodes(*model, random, 0, [](ModelEdgeId) { return 12; });
  const Tessellation side = model->face_geometry(ModelFaceId(0))->tessellate(1, 1);
  auto chains = nodes.chains(ModelFaceId(0));
  CHECK(make_facet_patch(side, nodes.chains(ModelFaceId(1))).verdict == FacetPatchVerdict::ChainsDisagree);
  CHECK(make_facet_patch(side, {}).verdict == FacetPatchVerdict::ChainsDisagree);
  chains.push_back(chains[0]);
  CHECK(make_facet_patch(side, chains).verdict == FacetPatchVerdict::ChainsDisagree);
}

TEST_CASE("facets that are no manifold are refused with a point") {
  Tessellation fan;
  fan.points = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}};
  fan.tri_to_vert = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}};
  fan.uv.resize(5), fan.edge_parameter.resize(5);
  fan.classification.assign(5, ModelFaceId(0));
  const FacetPatch patch = make_facet_patch(fan, {});
  CHECK(patch.verdict == FacetPatchVerdict::NotManifold);
  CHECK(patch.points.empty());
  CHECK(distance(patch.trouble, {0, 0, 0.5}) <= 0.5);
  fan.tri_to_vert.resize(1);
  CHECK(make_facet_patch(fan, {}).verdict == FacetPatchVerdict::NotManifold);  // an open rim on no model edge
}

TEST_CASE("a disc with a rim of two nodes cannot be, and is refused") {
  std::mt19937 random(1);
  const auto model = discrete(disc(24, 4, 0));
  const Nodes nodes(*model, random, 0, [](ModelEdgeId) { return 4; });
  auto chains = nodes.chains(ModelFaceId(0));
  chains[0].nodes.erase(chains[0].nodes.begin() + 1, chains[0].nodes.begin() + 3);
  const FacetPatch patch = make_facet_patch(model->face_geometry(ModelFaceId(0))->tessellate(1, 1), chains);
  CHECK(patch.verdict == FacetPatchVerdict::Stuck);
  CHECK(patch.tri_to_vert.empty());
}

TEST_CASE("a jagged rim takes nodes however coarse, if need be with triangles that face away, which are counted") {
  const unsigned seed = GENERATE(range(1u, 61u));
  INFO("seed " << seed);
  std::mt19937 random(seed);
  const auto columns = static_cast<std::uint32_t>(16 + 2 * (random() % 20)),
             rings = static_cast<std::uint32_t>(1 + random() % 4);
  shapes::Facets facets = disc(columns, rings, seed % 2);
  const double depth = 3.0 / columns;
  for (std::uint32_t i = 0; i < columns; i += 2) {
    Vec3& p = facets.points[1 + (rings - 1) * columns + i];
    p = {(1 - depth) * p.x, (1 - depth) * p.y, p.z + (random() % 2 ? depth : 0)};
  }
  const auto model = make_discrete_model(facets.points, facets.triangles, 2.9);
  const int pieces = 3 + static_cast<int>(random() % 6);
  const Nodes nodes(*model, random, 1, [&](ModelEdgeId) { return pieces; });
  REQUIRE(model->topology().face_count() == 1);
  const auto face = model->face_geometry(ModelFaceId(0));
  const auto chains = nodes.chains(ModelFaceId(0));
  const auto size_at = [&](const Vec3&) { return seed % 3 ? 0.3 : 5.0; };
  const FacetPatch patch = make_facet_patch(face->tessellate(1, 1), chains, {}, size_at);
  REQUIRE(patch.verdict == FacetPatchVerdict::Ok);
  std::multiset<Edge> rim;
  const auto halves = half_edges_of(patch.tri_to_vert);
  for (const auto& [half, count] : halves) {
    CHECK(count == 1);
    if (!halves.count({half.second, half.first})) rim.insert({patch.node[half.first], patch.node[half.second]});
  }
  CHECK(rim == pieces_of(chains));
  CHECK(euler_of(patch.tri_to_vert) == 1);
  CHECK(patch.inverted < patch.tri_to_vert.size());
}

TEST_CASE("long edges become short near a center, and only as short as their distance further away") {
  constexpr std::uint32_t kSpokes = 400;
  Triangulation mesh;
  detail::PatchVertices vertices;
  for (std::uint32_t i = 0; i <= kSpokes; ++i) {
    const double angle = 2 * M_PI * i / kSpokes;
    mesh.add_vertex();
    vertices.points.push_back(i == 0 ? Vec3{} : Vec3{std::cos(angle), std::sin(angle), 0});
    vertices.normals.push_back({0, 0, 1});
  }
  vertices.uv.resize(vertices.size()), vertices.entity.resize(vertices.size()), vertices.t.resize(vertices.size());
  vertices.node.resize(vertices.size(), FacetPatch::kNoNode), vertices.sharp.resize(vertices.size());
  for (std::uint32_t i = 0; i < kSpokes; ++i) {
    const std::uint32_t t = mesh.add_triangle(0, i + 1, (i + 1) % kSpokes + 1);
    if (i > 0) mesh.link(3 * t, 3 * (t - 1) + 2);
  }
  mesh.link(0, 3 * (kSpokes - 1) + 2);
  const double size = 1e-3;
  const std::function<double(const Vec3&)> size_at = [&](const Vec3&) { return size; };
  const std::vector<std::uint32_t> centers{0};
  detail::halve_long_edges(mesh, vertices, centers, {{}, size_at});
  CHECK(mesh.validate());
  mesh.for_each_outgoing(0, [&](std::uint32_t h) {
    CHECK(distance({}, vertices.points[mesh.target(h)]) < 1.5 * size);
    return true;
  });
  CHECK(vertices.size() < 40 * kSpokes);  // a thousand per spoke otherwise
}

TEST_CASE("a call ends when the host says so") {
  std::mt19937 random(1);
  const auto model = discrete(disc(24, 4, 0));
  const Nodes nodes(*model, random, 0, [](ModelEdgeId) { return 5; });
  const auto face = model->face_geometry(ModelFaceId(0));
  const auto patch = make_facet_patch(face->tessellate(1, 1), nodes.chains(ModelFaceId(0)), [] { return false; });
  CHECK(patch.verdict == FacetPatchVerdict::Cancelled);
}

// The operator on cavities, against what its definition says, tet by tet.
#include "adapt/kernel/cavity_mesh.hpp"
#include "tetloom/tasks.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <numeric>
#include <optional>
#include <random>
#include <set>

#include "adapt/kernel/ring_in_metric.hpp"
#include "adapt/kernel/star_cavity.hpp"
#include "adapt/parts/rounds.hpp"
#include "core/tets/ring_triangulation.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/check.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

using Tet = std::array<std::uint32_t, 4>;
using Core = std::vector<std::uint32_t>;

/// The same for all orders of the vertices that turn the tet alike.
Tet canonical(Tet v) {
  bool odd = false;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j + 1 < 4; ++j)
      if (v[j] > v[j + 1]) std::swap(v[j], v[j + 1]), odd = !odd;
  if (odd) std::swap(v[2], v[3]);
  return v;
}

struct NamedTet {
  Tet verts;
  std::uint32_t region;
  friend auto operator<=>(const NamedTet&, const NamedTet&) = default;
};

struct NamedTriangle {
  Triangle verts;  ///< its lowest vertex first
  std::uint32_t face;
  friend auto operator<=>(const NamedTriangle&, const NamedTriangle&) = default;
};

Triangle turned_first(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

/// All that an operation changes, as plain lists.
struct NamedContents {
  std::vector<NamedTet> tets;
  std::vector<NamedTriangle> triangles;
  std::vector<ModelEdgePiece> edges;
  friend bool operator==(const NamedContents&, const NamedContents&) = default;

  void sort() {
    std::sort(tets.begin(), tets.end()), std::sort(triangles.begin(), triangles.end());
    std::sort(edges.begin(), edges.end());
  }
};

NamedContents named_contents(const CavityMesh& mesh) {
  NamedContents contents;
  for (std::uint32_t t = 0; t < mesh.mesh.size(); ++t) {
    if (mesh.mesh.is_dead(t)) continue;
    Tet v{};
    std::copy_n(mesh.verts(t), 4, v.begin());
    contents.tets.push_back({canonical(v), mesh.mesh.to_region[t]});
  }
  mesh.surface.for_each_triangle([&](const SurfaceTriangle& t) {
    contents.triangles.push_back({turned_first(t.verts), t.face});
  });
  mesh.surface.for_each_edge([&](std::uint32_t a, std::uint32_t b, std::uint32_t edge) {
    contents.edges.push_back({{std::min(a, b), std::max(a, b)}, edge});
  });
  contents.sort();
  return contents;
}

/// `list` of simplices with `core` replaced by p, as the header of cavity_mesh.hpp has it.
template <std::size_t N>
std::vector<std::array<std::uint32_t, N>> replaced(const std::array<std::uint32_t, N>& verts, const Core& core,
                                                   std::uint32_t p) {
  const auto has = [&](std::uint32_t v) { return std::find(verts.begin(), verts.end(), v) != verts.end(); };
  if (!std::all_of(core.begin(), core.end(), has)) return {verts};
  if (has(p) && std::find(core.begin(), core.end(), p) == core.end()) return {};
  std::vector<std::array<std::uint32_t, N>> made;
  for (const std::uint32_t c : core) {
    auto one = verts;
    std::replace(one.begin(), one.end(), c, p);
    made.push_back(one);
  }
  return made;
}

NamedContents expected(const NamedContents& before, const Core& core, std::uint32_t p) {
  NamedContents after;
  for (const NamedTet& tet : before.tets)
    for (const Tet& v : replaced(tet.verts, core, p)) after.tets.push_back({canonical(v), tet.region});
  for (const NamedTriangle& triangle : before.triangles)
    for (const Triangle& v : replaced(triangle.verts, core, p))
      after.triangles.push_back({turned_first(v), triangle.face});
  for (const ModelEdgePiece& piece : before.edges)
    for (const auto& v : replaced(piece.verts, core, p))
      after.edges.push_back({{std::min(v[0], v[1]), std::max(v[0], v[1])}, piece.edge});
  after.sort();
  return after;
}

std::map<std::uint32_t, double> volumes_of(const CavityMesh& mesh) {
  std::map<std::uint32_t, double> volumes;
  for (std::uint32_t t = 0; t < mesh.mesh.size(); ++t) {
    if (mesh.mesh.is_dead(t)) continue;
    const std::uint32_t* v = mesh.verts(t);
    const Vec3& x = mesh.point(v[0]);
    volumes[mesh.mesh.to_region[t]] += dot(cross(mesh.point(v[1]) - x, mesh.point(v[2]) - x), mesh.point(v[3]) - x) / 6;
  }
  return volumes;
}

long euler_characteristic(const NamedContents& contents) {
  std::set<std::uint32_t> verts;
  std::set<std::array<std::uint32_t, 2>> edges;
  std::set<Triangle> faces;
  for (const NamedTet& tet : contents.tets) {
    Tet v = tet.verts;
    std::sort(v.begin(), v.end());
    for (std::size_t i = 0; i < 4; ++i) {
      verts.insert(v[i]);
      Triangle face{};
      std::copy_if(v.begin(), v.end(), face.begin(), [&](std::uint32_t u) { return u != v[i]; });
      faces.insert(face);
      for (std::size_t j = 0; j < i; ++j) edges.insert({v[j], v[i]});
    }
  }
  return static_cast<long>(verts.size()) - static_cast<long>(edges.size()) + static_cast<long>(faces.size()) -
         static_cast<long>(contents.tets.size());
}

/// Everything that the mesh keeps beside its tets must follow from them.
void check_invariants(const CavityMesh& mesh) {
  REQUIRE(tets::find_fault(mesh.mesh) == "");
  std::size_t fixed = 0;
  for (const FaceCode face : mesh.mesh.faces()) {
    if (mesh.mesh.is_dead(face.tet())) continue;
    const bool is_triangle = mesh.surface.find(tets::verts_of(mesh.mesh, face)) != nullptr;
    REQUIRE(is_triangle == mesh.mesh.is_fixed(face));
    const FaceCode behind = mesh.mesh.behind(face);
    fixed += is_triangle && (!behind.valid() || face < behind);
  }
  REQUIRE(fixed == mesh.surface.triangle_count());
  for (std::uint32_t t = 0; t < mesh.mesh.size(); ++t) {
    if (mesh.mesh.is_dead(t)) continue;
    const std::uint32_t* v = mesh.verts(t);
    REQUIRE(mesh.to_quality[t] == static_cast<float>(mesh.quality_of(v[0], v[1], v[2], v[3])));
    for (int i = 0; i < 4; ++i) {
      REQUIRE(mesh.vert_to_tet[v[i]] != kNone);
      REQUIRE(mesh.corner_of(mesh.vert_to_tet[v[i]], v[i]) < 4);
    }
  }
}

/// Random operations on one mesh, each against its definition.
class Mangler {
 public:
  Mangler(CavityMesh& mesh, unsigned seed) : mesh_(mesh), random_(seed) {}

  enum class Kind { Split, FacePoint, TetPoint, Collapse, EdgeSwap, FaceSwap, Move, SwapsAndCollapse, RingSwap, Count };

  /// Whether one was carried out.
  bool attempt(Kind kind) {
    const std::uint32_t tet = live_tet();
    std::array<std::uint32_t, 4> v{};
    std::copy_n(mesh_.verts(tet), 4, v.begin());
    std::shuffle(v.begin(), v.end(), random_);
    switch (kind) {
      case Kind::Split: return insert({v[0], v[1]}, tet);
      case Kind::FacePoint: return insert({v[0], v[1], v[2]}, tet);
      case Kind::TetPoint: return insert({v[0], v[1], v[2], v[3]}, tet);
      case Kind::Collapse: return carry_out({v[0]}, tet, v[1]);
      case Kind::EdgeSwap: return swap_edge({v[0], v[1]}, tet);
      case Kind::FaceSwap: return swap_face({v[0], v[1], v[2]}, tet, v[3]);
      case Kind::Move: return move(v[0], tet);
      case Kind::SwapsAndCollapse: return collapse_with_swaps();
      case Kind::RingSwap: return swap_ring({v[0], v[1]}, tet);
      case Kind::Count: break;
    }
    return false;
  }

 private:
  std::uint32_t below(std::size_t n) { return static_cast<std::uint32_t>(random_() % n); }
  double uniform() { return 0.2 + 0.6 * static_cast<double>(random_()) / 4294967296.0; }

  std::uint32_t live_tet() {
    for (;;) {
      const std::uint32_t tet = below(mesh_.mesh.size());
      if (!mesh_.mesh.is_dead(tet)) return tet;
    }
  }

  PackedEntity entity_of(const Core& core) const {
    if (cavity_.surface.empty()) return PackedEntity(ModelEntity(3, mesh_.mesh.to_region[cavity_.tets[0]]));
    const std::uint32_t edge = core.size() == 2 ? mesh_.surface.find_edge(core[0], core[1]) : kNone;
    if (edge != kNone) return PackedEntity(ModelEntity(1, edge));
    return PackedEntity(ModelEntity(2, mesh_.surface.find(tets::verts_of(mesh_.mesh, cavity_.surface[0]))->face));
  }

  void collect(const Core& core, std::uint32_t tet) {
    REQUIRE(mesh_.collect(core, tet, cavity_));
    std::vector<std::uint32_t> all;
    for (std::uint32_t t = 0; t < mesh_.mesh.size(); ++t) {
      if (mesh_.mesh.is_dead(t)) continue;
      if (std::all_of(core.begin(), core.end(), [&](std::uint32_t c) { return mesh_.corner_of(t, c) < 4; }))
        all.push_back(t);
    }
    std::vector<std::uint32_t> found(cavity_.tets.begin(), cavity_.tets.end());
    std::sort(found.begin(), found.end());
    REQUIRE(found == all);
    float least = 2;
    for (const std::uint32_t t : all) least = std::min(least, mesh_.to_quality[t]);
    REQUIRE(cavity_.least == double{least});
  }

  // Near the middle, on the simplex: on planes along the axes to the last bit.
  bool insert(const Core& core, std::uint32_t tet) {
    Vec3 x = mesh_.point(core[0]);
    for (std::size_t i = 1; i < core.size(); ++i)
      x += uniform() / static_cast<double>(i + 1) * (mesh_.point(core[i]) - x);
    collect(core, tet);
    const std::uint32_t p = mesh_.add_vertex(x, isotropic(1), entity_of(core), kNone);
    if (carry_out(core, tet, p)) return true;
    mesh_.drop_last_vertex();
    return false;
  }

  bool swap_edge(const Core& core, std::uint32_t tet) {
    collect(core, tet);
    if (mesh_.surface.find_edge(core[0], core[1]) != kNone) return false;
    std::vector<std::uint32_t> ring;
    const auto add = [&](std::uint32_t u) {
      if (u != core[0] && u != core[1]) ring.push_back(u);
    };
    if (cavity_.surface.empty()) {
      for (const std::uint32_t t : cavity_.tets) std::for_each(mesh_.verts(t), mesh_.verts(t) + 4, add);
    } else {
      if (cavity_.surface.size() != 2) return false;
      for (const FaceCode face : cavity_.surface)
        for (const std::uint32_t u : tets::verts_of(mesh_.mesh, face)) add(u);
    }
    return carry_out(core, tet, ring[below(ring.size())]);
  }

  // The best triangulation of a ring's places from i to j, among all.
  double best_of_all(const tets::EdgeRing& ring, int i, int j) const {
    if (j - i < 2) return 2;
    double best = 0;
    for (int k = i + 1; k < j; ++k) {
      double worst = std::min(best_of_all(ring, i, k), best_of_all(ring, k, j));
      const tets::RingTriangle triangle{static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(k),
                                        static_cast<std::uint8_t>(j)};
      for (const Tet& v : tets_over(ring, triangle)) worst = std::min(worst, mesh_.quality_of(v[0], v[1], v[2], v[3]));
      best = std::max(best, worst);
    }
    return best;
  }

  bool swap_ring(const Core& core, std::uint32_t tet) {
    collect(core, tet);
    tets::EdgeRing ring;
    if (!cavity_.surface.empty() || cavity_.tets.size() > 8 || !mesh_.find_ring(cavity_, ring)) return false;
    NamedContents goal = named_contents(mesh_);
    for (std::size_t i = 0; i < ring.old().size(); ++i) {
      const Tet around{ring.a, ring.b, ring.verts[i], ring.verts[(i + 1) % ring.old().size()]};
      const auto old = std::ranges::find(goal.tets, canonical(around), &NamedTet::verts);
      REQUIRE(old != goal.tets.end());
      goal.tets.erase(old);
    }
    const RingInMetric qualities(mesh_, ring);
    tets::RingTriangulation triangulation(qualities, ring.count);
    const double least = triangulation.maximize(0);
    REQUIRE(least == Approx(best_of_all(ring, 0, ring.count - 1)).epsilon(1e-9));
    if (!(least > 1e-9)) return false;
    const tets::RingTriangles triangles = triangulation.triangles();
    const std::uint32_t region = mesh_.mesh.to_region[tet];
    for (const tets::RingTriangle& triangle : triangles.list())
      for (const Tet& v : tets_over(ring, triangle)) goal.tets.push_back({canonical(v), region});
    goal.sort();
    mesh_.replace_ring(ring, triangles.list());
    REQUIRE(named_contents(mesh_) == goal);
    check_invariants(mesh_);
    return true;
  }

  bool swap_face(const Core& core, std::uint32_t tet, std::uint32_t own) {
    const FaceCode face(tet, mesh_.corner_of(tet, own)), behind = mesh_.mesh.behind(face);
    if (!behind.valid() || mesh_.mesh.is_fixed(face)) return false;
    return carry_out(core, tet, mesh_.mesh.apex(behind));
  }

  bool move(std::uint32_t v, std::uint32_t tet) {
    if (mesh_.dim_of(v) < 3) return false;
    const Vec3 before = mesh_.point(v);
    mesh_.mesh.points[v] += 0.1 * Vec3{uniform() - 0.5, uniform() - 0.5, uniform() - 0.5};
    // Nothing is connected anew: qualities are all that changes.
    collect({v}, tet);
    MadeQualities made;
    const bool moved = mesh_.evaluate(cavity_, v, 1e-9, made) > 1e-9;
    if (!moved) mesh_.mesh.points[v] = before;
    for (const std::uint32_t t : cavity_.tets) {
      const std::uint32_t* c = mesh_.verts(t);
      mesh_.to_quality[t] = static_cast<float>(mesh_.quality_of(c[0], c[1], c[2], c[3]));
    }
    for (std::size_t i = 0; moved && i < made.size(); ++i) REQUIRE(mesh_.to_quality[cavity_.tets[i]] == made[i]);
    check_invariants(mesh_);
    return moved;
  }

  // What the model allows, and no triangle of a box's side turns over.
  bool is_allowed(const Core& core, std::uint32_t p) const {
    if (cavity_.surface.empty() || core.size() != 1 || core[0] == p) return true;
    const ModelEntity entity = mesh_.to_entity[core[0]].unpack();
    if (entity.dim == 0) return false;
    if (entity.dim == 1) return mesh_.surface.find_edge(core[0], p) == entity.index;
    const auto has_p = [&](FaceCode face) {
      const Triangle v = tets::verts_of(mesh_.mesh, face);
      return std::find(v.begin(), v.end(), p) != v.end();
    };
    return std::any_of(cavity_.surface.begin(), cavity_.surface.end(), has_p);
  }

  bool carry_out(const Core& core, std::uint32_t tet, std::uint32_t p) {
    collect(core, tet);
    if (!is_allowed(core, p)) return false;
    MadeQualities made;
    const double least = mesh_.evaluate(cavity_, p, 0, made);
    if (!(least > 1e-9)) return false;
    if (!cavity_.surface.empty() && !mesh_.is_sound(cavity_, p)) return false;
    const NamedContents goal = expected(named_contents(mesh_), core, p);
    mesh_.reconnect(cavity_, p, made);
    REQUIRE(named_contents(mesh_) == goal);
    check_invariants(mesh_);
    if (core.size() == 1 && core[0] != p) REQUIRE(mesh_.vert_to_tet[core[0]] == kNone);
    return true;
  }

  // Where a plain collapse would invert tets: few edges inside do.
  bool collapse_with_swaps() {
    for (int i = 0; i < 400; ++i) {
      const std::uint32_t tet = live_tet(), j = below(4), from = mesh_.verts(tet)[j];
      if (mesh_.dim_of(from) == 3 && collapse_with_swaps(from, tet, mesh_.verts(tet)[(j + 1 + below(3)) % 4]))
        return true;
    }
    return false;
  }

  bool collapse_with_swaps(std::uint32_t from, std::uint32_t tet, std::uint32_t to) {
    REQUIRE(mesh_.collect(std::span(&from, 1), tet, cavity_));
    MadeQualities made;
    if (mesh_.evaluate(cavity_, to, 0, made) > 1e-9 || !star_cavity_.find(cavity_, to, 1e-9)) return false;
    const NamedContents before = named_contents(mesh_);
    const auto volumes = volumes_of(mesh_);
    star_cavity_.fill();
    check_invariants(mesh_);
    const NamedContents after = named_contents(mesh_);
    REQUIRE(after.triangles == before.triangles);
    REQUIRE(after.edges == before.edges);
    for (const auto& [region, volume] : volumes_of(mesh_)) REQUIRE(volume == Approx(volumes.at(region)).epsilon(1e-12));
    // What is new has `to`, and no other vertex than `from` has gone.
    for (const NamedTet& one : after.tets)
      REQUIRE((std::ranges::binary_search(before.tets, one) || std::ranges::find(one.verts, to) != one.verts.end()));
    std::set<std::uint32_t> verts_before, verts_after;
    for (const NamedTet& one : before.tets) verts_before.insert(one.verts.begin(), one.verts.end());
    for (const NamedTet& one : after.tets) verts_after.insert(one.verts.begin(), one.verts.end());
    verts_before.erase(from);
    REQUIRE(verts_after == verts_before);
    REQUIRE(mesh_.vert_to_tet[from] == kNone);
    return true;
  }

  CavityMesh& mesh_;
  std::mt19937 random_;
  Cavity cavity_;
  StarCavity star_cavity_{mesh_};
};

/// Calls `visit` with the only part of a box of tets.
void with_part(const Mesh& mesh, const std::function<void(CavityMesh&)>& visit, WholeMesh* result = nullptr) {
  const TaskRunner runner(1);
  WholeMesh whole = make_whole_mesh(mesh, runner);
  for (VertexMetric& metric : whole.to_metric) metric = {isotropic(1), 1};
  ShareLinks links = take_share(whole);
  Dealing dealing{.to_part = {}, .work = {1}};
  dealing.to_part.resize(whole.size(), 0);
  adapt_in_parts(whole, links, std::move(dealing), {[&](std::size_t, CavityMesh& part) { visit(part); }}, runner);
  if (result) *result = std::move(whole);
}

}  // namespace

TEST_CASE("operations on cavities do what their definition says", "[cavity_mesh]") {
  const bool two_regions = GENERATE(false, true);
  const unsigned seed = GENERATE(1u, 2u, 3u);
  CAPTURE(two_regions, seed);
  const Mesh box = test::make_tet_box(2, 2, 2, seed, two_regions);
  WholeMesh whole;
  std::array<int, static_cast<std::size_t>(Mangler::Kind::Count)> done{};
  const auto mangle = [&](CavityMesh& part) {
    check_invariants(part);
    const auto volumes = volumes_of(part);
    const long characteristic = euler_characteristic(named_contents(part));
    CHECK(characteristic == 1);
    Mangler mangler(part, seed);
    std::mt19937 random(seed + 7);
    for (int i = 0; i < 700; ++i) {
      // Fewer insertions than removals once there is something to remove.
      auto kind = static_cast<Mangler::Kind>(random() % done.size());
      if (part.mesh.size() > 400 && kind <= Mangler::Kind::TetPoint) kind = Mangler::Kind::Collapse;
      done[static_cast<std::size_t>(kind)] += mangler.attempt(kind);
    }
    for (const auto& [region, volume] : volumes_of(part)) CHECK(volume == Approx(volumes.at(region)).epsilon(1e-12));
    CHECK(euler_characteristic(named_contents(part)) == characteristic);
    const NamedContents before = named_contents(part);
    part.renumber(true);
    check_invariants(part);
    CHECK(named_contents(part).tets.size() == before.tets.size());
  };
  with_part(box, mangle, &whole);
  for (const int count : done) CHECK(count >= 5);
  const ValidationReport validation = validate_mesh(make_mesh_of(whole, box, TaskRunner(1)));
  for (const MeshProblem& problem : validation.problems) FAIL_CHECK(problem.message);
}

TEST_CASE("what cannot be collected is refused", "[cavity_mesh]") {
  with_part(test::make_tet_box(2, 2, 2), [](CavityMesh& part) {
    Cavity cavity;
    CHECK(part.find_edge(0, 26, cavity) == kNone);
    const std::uint32_t tet = part.find_edge(part.verts(0)[0], part.verts(0)[1], cavity);
    REQUIRE(tet != kNone);
    CHECK(part.corner_of(tet, part.verts(0)[0]) < 4);
    // A vertex with more tets than a cavity may have.
    std::uint32_t inside = 0;
    while (part.dim_of(inside) < 3) ++inside;
    MadeQualities made;
    for (int i = 0; i < 400; ++i) {
      if (!part.collect(std::span(&inside, 1), part.vert_to_tet[inside], cavity)) break;
      // Points in tets at the vertex: two more of them there, each time.
      const std::uint32_t t = *std::max_element(cavity.tets.begin(), cavity.tets.end(), [&](auto a, auto b) {
        return part.to_quality[a] < part.to_quality[b];
      });
      Core core(part.verts(t), part.verts(t) + 4);
      Vec3 x;
      for (const std::uint32_t c : core) x += 0.25 * part.point(c);
      REQUIRE(part.collect(core, t, cavity));
      const std::uint32_t p = part.add_vertex(x, isotropic(1), PackedEntity(ModelEntity(3, 0)), kNone);
      REQUIRE(part.evaluate(cavity, p, 0, made) > 0);
      part.reconnect(cavity, p, made);
    }
    CHECK_FALSE(part.collect(std::span(&inside, 1), part.vert_to_tet[inside], cavity));
    CHECK(tets::find_fault(part.mesh) == "");
  });
}

TEST_CASE("a triangle that would lie on another one is refused", "[cavity_mesh]") {
  // Two tets with a face in common, each of its own region: that face is an interface. To collapse one's tip into a
  // vertex of it would put its sides onto the interface.
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.tet_to_vert = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  mesh.tet_to_entity = {0, 1};
  mesh.tri_to_vert = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}, {0, 4, 1}, {1, 4, 2}, {0, 2, 4}};
  mesh.tri_to_entity = {0, 1, 1, 1, 2, 2, 2};
  with_part(mesh, [](CavityMesh& part) {
    check_invariants(part);
    for (std::uint32_t v = 0; v < 5; ++v) {
      for (std::uint32_t to = 0; to < 5; ++to) {
        Cavity cavity;
        REQUIRE(part.collect(std::span(&v, 1), part.vert_to_tet[v], cavity));
        if (v != to && part.find_edge(v, to, cavity) != kNone) {
          REQUIRE(part.collect(std::span(&v, 1), part.vert_to_tet[v], cavity));
          CHECK_FALSE(part.is_sound(cavity, to));
        }
      }
    }
  });
}

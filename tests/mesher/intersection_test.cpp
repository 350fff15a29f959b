// Self-intersection of surfaces: neighbours by case, an oracle over all pairs in integer arithmetic, whole surfaces.
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <random>

#include "core/predicates/predicates.hpp"
#include "core/spatial/distances.hpp"
#include "mesher/intersection/self_intersection.hpp"
#include "mesher/intersection/triangle_pair.hpp"
#include "mesher/intersection/triangle_tree.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/simulated_ranks.hpp"

using namespace tetloom;
using namespace tetloom::intersection;

namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

struct Surface {
  std::vector<Vec3> points;
  Triangles triangles;
};

std::vector<TriangleIntersection> search(const Surface& surface, int threads = 2,
                                         std::span<const std::uint32_t> groups = {}) {
  return find_self_intersections({surface.points, surface.triangles, groups, 100000}, TaskRunner(threads));
}

// A grid of n x n squares over the unit square, each cut in two, lifted by `height`.
template <class Height>
Surface sheet(std::uint32_t n, Height&& height) {
  Surface surface;
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) {
      const double x = double(i) / n, y = double(j) / n;
      surface.points.push_back({x, y, height(x, y)});
    }
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      surface.triangles.push_back({a, b, d});
      surface.triangles.push_back({a, d, c});
    }
  }
  return surface;
}

// An oracle of its own kind: a linear program in disguise. Two triangles meet exactly when no plane from a finite set
// of candidates separates them strictly: the two planes, and those spanned by an edge of each. In one plane the
// candidates are the lines of the edges. In exact integers.
using Int3 = std::array<long, 3>;
Int3 minus(const Int3& a, const Int3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Int3 cross3(const Int3& a, const Int3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
long dot3(const Int3& a, const Int3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

bool separates(const Int3& n, const std::array<Int3, 3>& a, const std::array<Int3, 3>& b) {
  long a_lo = dot3(n, a[0]), a_hi = a_lo, b_lo = dot3(n, b[0]), b_hi = b_lo;
  for (int i = 1; i < 3; ++i) {
    a_lo = std::min(a_lo, dot3(n, a[i])), a_hi = std::max(a_hi, dot3(n, a[i]));
    b_lo = std::min(b_lo, dot3(n, b[i])), b_hi = std::max(b_hi, dot3(n, b[i]));
  }
  return a_hi < b_lo || b_hi < a_lo;
}

bool oracle_disjoint(const std::array<Int3, 3>& a, const std::array<Int3, 3>& b) {
  const Int3 na = cross3(minus(a[1], a[0]), minus(a[2], a[0])), nb = cross3(minus(b[1], b[0]), minus(b[2], b[0]));
  if (separates(na, a, b) || separates(nb, a, b)) return true;
  for (int i = 0; i < 3; ++i) {
    const Int3 ea = minus(a[(i + 1) % 3], a[i]), eb = minus(b[(i + 1) % 3], b[i]);
    if (separates(cross3(na, ea), a, b) || separates(cross3(nb, eb), a, b)) return true;
    for (int j = 0; j < 3; ++j) {
      if (separates(cross3(ea, minus(b[(j + 1) % 3], b[j])), a, b)) return true;
    }
  }
  return false;
}

Vec3 to_vec(const Int3& p) { return {double(p[0]), double(p[1]), double(p[2])}; }

}  // namespace

TEST_CASE("two triangles without a common vertex meet exactly when the oracle finds no separating plane") {
  const unsigned seed = 77001;
  CAPTURE(seed);
  std::mt19937_64 engine(seed);
  int meeting = 0, flat = 0;
  for (int round = 0; round < 60000; ++round) {
    const long range = round % 2 == 0 ? 2 : 6;
    std::uniform_int_distribution<long> coordinate(-range, range);
    std::array<std::array<Int3, 3>, 2> t;
    for (auto& triangle : t) {
      for (Int3& p : triangle) p = {coordinate(engine), coordinate(engine), round % 5 == 0 ? 1 : coordinate(engine)};
    }
    std::vector<Vec3> points;
    for (const auto& triangle : t) {
      for (const Int3& p : triangle) points.push_back(to_vec(p));
    }
    if (is_degenerate(points[0], points[1], points[2]) || is_degenerate(points[3], points[4], points[5])) continue;
    const bool expected = !oracle_disjoint(t[0], t[1]);
    meeting += expected;
    flat += round % 5 == 0;
    const auto verdict = check_pair(points, {0, 1, 2}, {3, 4, 5});
    REQUIRE(verdict.has_value() == expected);
    REQUIRE(check_pair(points, {5, 3, 4}, {2, 1, 0}).has_value() == expected);
    if (verdict) {
      CHECK(distance_to_triangle(verdict->point, points[0], points[1], points[2]) < 1e-12 * double(range));
      CHECK(distance_to_triangle(verdict->point, points[3], points[4], points[5]) < 1e-12 * double(range));
    }
  }
  CHECK(meeting > 5000);
  CHECK(flat > 5000);
}

TEST_CASE("two triangles with a common vertex meet beyond it exactly when they still do with the corner cut off") {
  // What they have in common reaches a side opposite to the shared corner; the oracle tests those sides as triangles
  // that are thin towards the corner: the same triangles shrunk away from it, by a rational factor.
  const unsigned seed = 77002;
  CAPTURE(seed);
  std::mt19937_64 engine(seed);
  int meeting = 0;
  for (int round = 0; round < 60000; ++round) {
    const long range = round % 2 == 0 ? 1 : 4;
    std::uniform_int_distribution<long> coordinate(-range, range);
    const auto draw = [&] {
      return Int3{coordinate(engine), coordinate(engine), round % 4 == 0 ? 0 : coordinate(engine)};
    };
    const Int3 o{0, 0, 0}, b = draw(), c = draw(), d = draw(), e = draw();
    const std::vector<Vec3> points{to_vec(o), to_vec(b), to_vec(c), to_vec(d), to_vec(e)};
    if (is_degenerate(points[0], points[1], points[2]) || is_degenerate(points[0], points[3], points[4])) continue;
    // A side and a triangle meet when the side, as the flat limit of a triangle, is not separated from it. The side's
    // triangle is doubled by a point of the side itself, so that the candidates of the oracle still suffice.
    const auto side_meets = [](const Int3& p, const Int3& q, const std::array<Int3, 3>& t) {
      const Int3 n = cross3(minus(t[1], t[0]), minus(t[2], t[0])), u = minus(q, p);
      const std::array<Int3, 3> segment{p, q, p};
      if (separates(n, segment, t)) return false;
      if (u == Int3{0, 0, 0}) {
        for (int i = 0; i < 3; ++i) {
          if (separates(cross3(n, minus(t[(i + 1) % 3], t[i])), segment, t)) return false;
        }
        return true;
      }
      if (separates(cross3(n, u), segment, t)) return false;
      for (int i = 0; i < 3; ++i) {
        const Int3 edge = minus(t[(i + 1) % 3], t[i]);
        if (separates(cross3(u, edge), segment, t) || separates(cross3(n, edge), segment, t)) return false;
      }
      return true;
    };
    const bool expected = side_meets(b, c, {o, d, e}) || side_meets(d, e, {o, b, c});
    meeting += expected;
    REQUIRE(check_pair(points, {0, 1, 2}, {0, 3, 4}).has_value() == expected);
    REQUIRE(check_pair(points, {4, 0, 3}, {2, 1, 0}).has_value() == expected);
  }
  CHECK(meeting > 3000);
}

TEST_CASE("neighbours across an edge meet only when folded flat onto each other") {
  std::vector<Vec3> p{{0, 0, 0}, {1, 0, 0}, {0.3, 1, 0}, {0.4, -1, 0}, {0.2, 0.5, 0}, {0.2, 0.5, 1e-12}};
  CHECK_FALSE(check_pair(p, {0, 1, 2}, {1, 0, 3}));
  CHECK(check_pair(p, {0, 1, 2}, {1, 0, 4}));
  CHECK_FALSE(check_pair(p, {0, 1, 2}, {1, 0, 5}));
  CHECK(check_pair(p, {0, 1, 2}, {2, 0, 1}));
}

TEST_CASE("smooth, flat and tilted sheets do not intersect themselves") {
  CHECK(search(sheet(30, [](double, double) { return 0.0; })).empty());
  CHECK(search(sheet(30, [](double x, double y) { return 0.1 * x + 0.3 * y; })).empty());
  CHECK(search(sheet(30, [](double x, double y) { return 0.3 * std::sin(7 * x) * std::cos(5 * y); })).empty());
}

TEST_CASE("two sheets that cross are found, but not when they are in different groups") {
  Surface surface = sheet(20, [](double, double) { return 0.0; });
  const Surface other = sheet(17, [](double x, double y) { return x - 0.5123 + 0.01 * y; });
  const auto offset = static_cast<std::uint32_t>(surface.points.size());
  std::vector<std::uint32_t> groups(surface.triangles.size(), 0);
  surface.points.insert(surface.points.end(), other.points.begin(), other.points.end());
  for (auto t : other.triangles) surface.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  groups.resize(surface.triangles.size(), 1);

  std::vector<std::pair<std::uint32_t, std::uint32_t>> expected;
  for (std::uint32_t i = 0; i < surface.triangles.size(); ++i) {
    for (std::uint32_t j = i + 1; j < surface.triangles.size(); ++j) {
      if (check_pair(surface.points, surface.triangles[i], surface.triangles[j])) expected.emplace_back(i, j);
    }
  }
  const auto found = search(surface);
  REQUIRE(found.size() == expected.size());
  REQUIRE(found.size() > 20);
  for (std::size_t i = 0; i < found.size(); ++i) CHECK(std::pair(found[i].first, found[i].second) == expected[i]);
  CHECK(search(surface, 2, groups).empty());

  const auto alone = search(surface, 1);
  REQUIRE(alone.size() == found.size());
  for (std::size_t i = 0; i < found.size(); ++i) CHECK(alone[i].point == found[i].point);
}

TEST_CASE("a sheet that passes through itself is described by its faces, a point and how often") {
  // A ribbon x -> (sin, 2 sin) crosses itself in a figure of eight.
  Surface surface = sheet(40, [](double, double) { return 0.0; });
  for (Vec3& p : surface.points) {
    const double t = -0.2 + 6 * p.x;
    p = {std::sin(t), p.y, std::sin(2 * t)};
  }
  std::vector<std::uint32_t> faces;
  for (const auto& t : surface.triangles) faces.push_back(t[0] % 41 < 20 ? 3 : 8);
  const auto found = search(surface);
  REQUIRE(!found.empty());
  const auto diagnostics = describe_intersections(found, {faces, nullptr});
  REQUIRE(diagnostics.size() == 1);
  CHECK(diagnostics[0].code == ErrorCode::SelfIntersection);
  REQUIRE(diagnostics[0].entities.size() == 2);
  CHECK(diagnostics[0].entities[0].entity == ModelEntity(2, 3));
  CHECK(diagnostics[0].entities[1].entity == ModelEntity(2, 8));
  REQUIRE(diagnostics[0].point);
  CHECK(std::abs(diagnostics[0].point->x) < 0.2);
  CHECK(!diagnostics[0].elements.empty());
  CHECK(diagnostics[0].message.find("face 4") != std::string::npos);
}

TEST_CASE("triangles without area and vertices that touch a triangle are reported") {
  Surface surface{
      {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 5, 0}, {1, 5, 0}, {0, 6, 0}, {0.2, 5.2, 0}, {0, 5, 1}, {1, 5, 1}},
      {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}}};
  const auto found = search(surface);
  REQUIRE(found.size() == 2);
  CHECK(found[0].kind == IntersectionKind::Degenerate);
  CHECK(found[0].first == found[0].second);
  CHECK(found[1].first == 1);
  CHECK(found[1].second == 2);
  CHECK(found[1].point == surface.points[6]);
}

TEST_CASE("an empty surface and one triangle have no intersections") {
  CHECK(search({}).empty());
  CHECK(search({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}).empty());
}

TEST_CASE("the number of intersections returned is bounded and does not depend on the threads") {
  Surface surface;  // 200 triangles through one axis
  for (std::uint32_t i = 0; i < 200; ++i) {
    const double angle = i * std::numbers::pi / 200;
    surface.points.push_back({0, 0, -1.0 - i});
    surface.points.push_back({0.001 * i, 0, 1.0 + i});
    surface.points.push_back({std::cos(angle), std::sin(angle), 0});
    surface.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const IntersectionSearch limited{surface.points, surface.triangles, {}, 50};
  const auto one = find_self_intersections(limited, TaskRunner(1)),
             two = find_self_intersections(limited, TaskRunner(2));
  REQUIRE(one.size() == 50);
  REQUIRE(two.size() == 50);
  for (std::size_t i = 0; i < 50; ++i) CHECK((one[i].first == two[i].first && one[i].second == two[i].second));
}

TEST_CASE("a cancelled search stops with Cancelled") {
  CancelToken token;
  token.cancel();
  const Surface surface = sheet(30, [](double, double) { return 0.0; });
  const TaskRunner runner(2, Host{{}, &token});
  CHECK_THROWS_AS(find_self_intersections({surface.points, surface.triangles, {}, 10}, runner), Error);
}

TEST_CASE("where some triangles are new, the crossings that they have a part in are found") {
  // Two crossing sheets side by side, of which one or the other is new.
  Surface both = sheet(12, [](double x, double) { return 0.3 * (x - 0.51); });
  const Surface flat = sheet(12, [](double, double) { return 0.0; });
  const auto first = static_cast<std::uint32_t>(both.points.size());
  const std::size_t own = both.triangles.size();
  both.points.insert(both.points.end(), flat.points.begin(), flat.points.end());
  for (auto tri : flat.triangles) {
    for (std::uint32_t& v : tri) v += first;
    both.triangles.push_back(tri);
  }
  const TaskRunner runner(2);
  IntersectionSearch search{both.points, both.triangles, {}};
  const auto all = find_self_intersections(search, runner);
  REQUIRE(all.size() > 10);
  const auto pairs = [](const std::vector<TriangleIntersection>& hits) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> list;
    for (const TriangleIntersection& hit : hits) list.emplace_back(hit.first, hit.second);
    return list;
  };
  for (const bool second_is_new : {false, true}) {
    std::vector<std::uint8_t> is_new(both.triangles.size(), 0);
    for (std::size_t t = 0; t < is_new.size(); ++t) is_new[t] = (t >= own) == second_is_new;
    search.tri_is_new = is_new;
    CHECK(pairs(find_self_intersections(search, runner)) == pairs(all));
  }
  // From none to so many that all triangles are searched: those that cross, and some that do not.
  std::vector<std::uint8_t> some(both.triangles.size(), 0);
  for (std::size_t count = 0; count < all.size(); ++count) {
    search.tri_is_new = some;
    auto expected = all;
    std::erase_if(expected, [&](const TriangleIntersection& hit) { return !some[hit.first] && !some[hit.second]; });
    CHECK(pairs(find_self_intersections(search, runner)) == pairs(expected));
    some[count % 2 == 0 ? all[count].second : all[count].first] = some[5 * count] = 1;
  }
}

TEST_CASE("the crossings above a point balance for rays through edges and vertices of a closed surface") {
  // The unit cube on a lattice, asked on the lattice: rays meet vertices, edges and vertical faces.
  Surface cube{{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 4}, {4, 0, 4}, {4, 4, 4}, {0, 4, 4}},
               {{0, 2, 1},
                {0, 3, 2},
                {4, 5, 6},
                {4, 6, 7},
                {0, 1, 5},
                {0, 5, 4},
                {1, 2, 6},
                {1, 6, 5},
                {2, 3, 7},
                {2, 7, 6},
                {3, 0, 4},
                {3, 4, 7}}};
  // Rays go along the shortest axis, whichever that is.
  for (const Vec3& stretch : {Vec3{1, 1, 1}, Vec3{4, 4, 1}, Vec3{1, 2, 8}, Vec3{2, 1, 8}}) {
    Surface block = cube;
    for (Vec3& x : block.points) x = {x.x * stretch.x, x.y * stretch.y, x.z * stretch.z};
    const TriangleTree tree(block.points, block.triangles, TaskRunner(1));
    for (int i = -1; i <= 5; ++i)
      for (int j = -1; j <= 5; ++j)
        for (const double k : {-1.0, 1.0, 2.5, 5.0}) {
          int balance = 0;
          const Vec3 x{i * stretch.x, j * stretch.y, k * stretch.z};
          tree.for_each_above(x, [&](std::uint32_t, bool up) { balance += up ? 1 : -1; });
          const auto lies_in = [](double s) { return s > 0 && s < 4; };
          const auto lies_out = [](double s) { return s < 0 || s > 4; };
          if (lies_in(i) && lies_in(j) && lies_in(k)) CHECK(balance == 1);
          if (lies_out(i) || lies_out(j) || lies_out(k)) CHECK(balance == 0);
        }
  }
  const TriangleTree tree(cube.points, cube.triangles, TaskRunner(1));
  CHECK(tree.any_within({2, 2, 5}, 1.01));
  CHECK_FALSE(tree.any_within({2, 2, 5}, 0.99));
  CHECK_FALSE(tree.any_within({2, 2, 2}, 1.99));
  CHECK(tree.any_within({5, 5, 5}, 1.74));
  CHECK_FALSE(tree.any_within({5, 5, 5}, 1.73));
}

TEST_CASE("boxes of the tree are told from each other exactly, also far from the origin") {
  const Vec3 far{3e7 + 0.1, -1e6, 7e5};
  Surface surface = sheet(20, [](double x, double y) { return 0.1 * std::sin(7 * x) * std::cos(5 * y); });
  for (Vec3& p : surface.points) p = p + far;
  const TriangleTree tree(surface.points, surface.triangles, TaskRunner(2));
  std::mt19937 random(11);
  const auto look = [&](const Box3& box) {
    std::vector<std::uint32_t> met, expected;
    tree.for_each_in(box, [&](std::uint32_t t) { met.push_back(t); });
    for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
      if (tree.box_of(t).overlaps(box)) expected.push_back(t);
    std::ranges::sort(met);
    CHECK(met == expected);
    bool any = false;
    for (std::size_t leaf = 0; leaf < tree.leaf_count(); ++leaf) {
      Box3 around;
      for (const std::uint32_t t : tree.leaf_triangles(leaf)) around.add(tree.box_of(t));
      any = any || around.overlaps(box);
    }
    CHECK(tree.may_meet(box) == any);
  };
  for (int i = 0; i < 300; ++i) {
    // Boxes that touch a corner from one side, and boxes one step of the coordinates away from it.
    const Vec3& corner = surface.points[random() % surface.points.size()];
    Box3 box{corner - Vec3{1, 1, 1}, corner};
    look(box);
    for (int axis = 0; axis < 3; ++axis) box.hi[axis] = std::nextafter(box.hi[axis], -HUGE_VAL);
    look(box);
  }
}

TEST_CASE("ranks make the tree that one process makes", "[ranks]") {
  const int ranks = GENERATE(2, 5);
  const Surface surface = sheet(100, [](double x, double y) { return 0.1 * std::sin(7 * x) * std::cos(5 * y); });
  const TriangleTree alone(surface.points, surface.triangles, TaskRunner(1));
  std::atomic<int> alike = 0;
  on_simulated_ranks(ranks, [&](Communicator& communicator) {
    const SharedWork work(1, {}, &communicator);
    std::optional<TriangleTree> tree;
    work.together([&] { tree.emplace(surface.points, surface.triangles, work); });
    bool are_equal = tree->leaf_count() == alone.leaf_count();
    for (std::size_t leaf = 0; are_equal && leaf < alone.leaf_count(); ++leaf)
      are_equal = std::ranges::equal(tree->leaf_triangles(leaf), alone.leaf_triangles(leaf));
    const auto met_by = [](const TriangleTree& one) {
      std::vector<std::uint32_t> met;
      one.for_each_in({{0.3, 0.3, -1}, {0.5, 0.6, 0.05}}, [&](std::uint32_t t) { met.push_back(t); });
      one.for_each_above({0.4, 0.7, -1}, [&](std::uint32_t t, bool up) { met.push_back(t * 2 + (up ? 1 : 0)); });
      return met;
    };
    alike += are_equal && met_by(*tree) == met_by(alone) && met_by(alone).size() > 100 ? 1 : 0;
  });
  CHECK(alike == ranks);
}

// Through points of triangles on purpose: corners, middles of edges, centres.
TEST_CASE("what a segment meets is visited, and little else") {
  const Surface surface = sheet(60, [](double x, double y) { return 0.3 * std::sin(7 * x) * std::cos(5 * y); });
  const TriangleTree tree(surface.points, surface.triangles, TaskRunner(1));
  std::mt19937 random(7);
  const auto unit = [&] { return double(random()) * 0x1p-32; };
  std::size_t visits = 0, in_boxes = 0;
  for (int i = 0; i < 200; ++i) {
    CAPTURE(i);
    const auto hit = static_cast<std::uint32_t>(random() % surface.triangles.size());
    const auto [a, b, c] = tree.corners_of(hit);
    const Vec3 aim = i % 3 == 0 ? a : i % 3 == 1 ? 0.5 * (a + b) : (1.0 / 3) * (a + b + c);
    const Vec3 from{unit(), unit(), 2 * unit() - 1};
    const Vec3 along = (i % 2 == 0 ? 1.0 : 1.7) * (aim - from);
    bool found = false;
    tree.for_each_along(from, along, [&](std::uint32_t triangle) { ++visits, found = found || triangle == hit; });
    CHECK(found);
    Box3 box;
    box.add(from), box.add(from + along);
    tree.for_each_in(box, [&](std::uint32_t) { ++in_boxes; });
  }
  CHECK(visits * 10 < in_boxes);
  std::size_t any = 0;
  tree.for_each_along({0.5, 0.5, 0.4}, {0, 0, 1}, [&](std::uint32_t) { ++any; });
  tree.for_each_along({-0.5, 0.5, 0}, {0.499, 0, 0}, [&](std::uint32_t) { ++any; });
  CHECK(any == 0);
}

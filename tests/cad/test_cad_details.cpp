// Inner parts of the CAD reader: chaining of loops, and evaluation of splines against OpenCASCADE's own.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <Geom_BSplineSurface.hxx>
#include <random>
#include <TColgp_Array2OfPnt.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColStd_Array2OfReal.hxx>

#include "core/cad/detail/conversions.hpp"
#include "core/cad/detail/loops.hpp"
#include "core/cad/detail/spline_surface.hpp"

using namespace tetloom;
using namespace tetloom::cad;

namespace {

/// A straight piece between two of the points, as edge `edge`.
LoopPiece piece(std::size_t edge, bool forward, std::size_t start, std::size_t end, const std::vector<Vec2>& points) {
  const Vec2 along = points[end] - points[start];
  return {{ModelEdgeId(edge), forward, false},
          ModelVertexId(start),
          ModelVertexId(end),
          points[start],
          points[end],
          0.01 * along,
          0.01 * along};
}

std::vector<std::size_t> edges_of(const ModelLoop& loop) {
  std::vector<std::size_t> result;
  for (const EdgeUse& use : loop) result.push_back(use.edge.value);
  return result;
}

using Edges = std::vector<std::size_t>;

}  // namespace

TEST_CASE("pieces in any order are chained to a loop that starts with the first") {
  const std::vector<Vec2> p{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const ChainedLoops chained =
      chain_loops({piece(2, true, 2, 3, p), piece(0, true, 0, 1, p), piece(3, true, 3, 0, p), piece(1, true, 1, 2, p)});
  CHECK(chained.open.empty());
  REQUIRE(chained.loops.size() == 1);
  CHECK(edges_of(chained.loops[0]) == Edges{2, 3, 0, 1});
}

//   3-------2
//   |   5   |      the spur 4-5 is run up and down on the way from 0 to 1
//   |   |   |
//   0---4---1
TEST_CASE("a spur is visited before the boundary goes on") {
  const std::vector<Vec2> p{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0}, {0.5, 0.5}};
  const ChainedLoops chained =
      chain_loops({piece(0, true, 0, 4, p), piece(1, true, 4, 1, p), piece(2, true, 1, 2, p), piece(3, true, 2, 3, p),
                   piece(4, true, 3, 0, p), piece(5, true, 4, 5, p), piece(5, false, 5, 4, p)});
  CHECK(chained.open.empty());
  REQUIRE(chained.loops.size() == 1);
  CHECK(edges_of(chained.loops[0]) == Edges{0, 5, 5, 1, 2, 3, 4});
}

// Two squares that touch in vertex 2 are two loops, not a figure eight.
TEST_CASE("a wire that touches itself in a vertex falls into simple loops") {
  const std::vector<Vec2> p{{0, 0}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}, {1, 0.5}, {1, 1}, {0.5, 1}};
  const ChainedLoops chained =
      chain_loops({piece(0, true, 0, 1, p), piece(1, true, 1, 2, p), piece(4, true, 2, 4, p), piece(5, true, 4, 5, p),
                   piece(6, true, 5, 6, p), piece(7, true, 6, 2, p), piece(2, true, 2, 3, p), piece(3, true, 3, 0, p)});
  CHECK(chained.open.empty());
  REQUIRE(chained.loops.size() == 2);
  CHECK(edges_of(chained.loops[0]) == Edges{0, 1, 2, 3});
  CHECK(edges_of(chained.loops[1]) == Edges{4, 5, 6, 7});
}

// A cylinder's side in (u,v): vertices 0 (below) and 1 (above) each stand on both sides of the seam.
TEST_CASE("a seam is run up on one side and down on the other") {
  const auto at = [](std::size_t edge, bool forward, bool second, std::size_t a, std::size_t b, Vec2 from, Vec2 to) {
    return LoopPiece{{ModelEdgeId(edge), forward, second},
                     ModelVertexId(a),
                     ModelVertexId(b),
                     from,
                     to,
                     0.01 * (to - from),
                     0.01 * (to - from)};
  };
  const ChainedLoops chained =
      chain_loops({at(0, true, false, 0, 0, {0, 0}, {1, 0}), at(1, false, true, 1, 0, {0, 1}, {0, 0}),
                   at(2, false, false, 1, 1, {1, 1}, {0, 1}), at(1, true, false, 0, 1, {1, 0}, {1, 1})});
  CHECK(chained.open.empty());
  REQUIRE(chained.loops.size() == 1);
  CHECK(edges_of(chained.loops[0]) == Edges{0, 1, 2, 1});
}

TEST_CASE("pieces that close no loop are handed back") {
  const std::vector<Vec2> p{{0, 0}, {1, 0}, {1, 1}};
  const ChainedLoops chained = chain_loops({piece(0, true, 0, 1, p), piece(1, true, 1, 2, p)});
  CHECK(chained.loops.empty());
  CHECK(chained.open.size() == 2);
  CHECK(chain_loops({}).loops.empty());
}

namespace {

struct SplineCase {
  int degree;
  bool periodic, rational;
};

/// Random poles over knots with every multiplicity up to the degree.
Handle(Geom_BSplineSurface) random_spline(const SplineCase& u, const SplineCase& v, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const auto knots_of = [&](const SplineCase& axis, int& poles) {
    const int count = 6;
    TColStd_Array1OfReal knots(1, count);
    TColStd_Array1OfInteger multiplicities(1, count);
    double at = -1;
    int sum = 0;
    for (int i = 1; i <= count; ++i) {
      knots(i) = at;
      at += 0.2 + unit(random);
      const bool end = i == 1 || i == count;
      multiplicities(i) = end ? (axis.periodic ? 1 : axis.degree + 1) : 1 + static_cast<int>(random() % axis.degree);
      sum += multiplicities(i);
    }
    poles = axis.periodic ? sum - 1 : sum - axis.degree - 1;
    return std::pair{knots, multiplicities};
  };
  int u_poles = 0, v_poles = 0;
  const auto [u_knots, u_multiplicities] = knots_of(u, u_poles);
  const auto [v_knots, v_multiplicities] = knots_of(v, v_poles);
  TColgp_Array2OfPnt poles(1, u_poles, 1, v_poles);
  TColStd_Array2OfReal weights(1, u_poles, 1, v_poles);
  for (int i = 1; i <= u_poles; ++i) {
    for (int j = 1; j <= v_poles; ++j) {
      poles(i, j) = gp_Pnt(3 * i + unit(random), 2 * j + unit(random), 4 * unit(random));
      weights(i, j) = u.rational || v.rational ? 0.5 + unit(random) : 1;
    }
  }
  return new Geom_BSplineSurface(poles, weights, u_knots, v_knots, u_multiplicities, v_multiplicities, u.degree,
                                 v.degree, u.periodic, v.periodic);
}

double error(const Vec3& ours, const gp_XYZ& theirs) {
  return distance(ours, to_vec3(theirs)) / (1 + norm(to_vec3(theirs)));
}

}  // namespace

TEST_CASE("splines are evaluated as OpenCASCADE evaluates them") {
  const unsigned seed = 7;
  std::printf("splines: seed %u\n", seed);
  std::mt19937 random(seed);
  const SplineCase cases[] = {{1, false, false}, {2, false, true}, {3, false, false}, {3, true, false},
                              {5, false, true},  {2, true, true},  {8, false, false}, {11, false, true}};
  for (const SplineCase& u : cases) {
    for (const SplineCase& v : cases) {
      INFO("degrees " << u.degree << " " << v.degree << " periodic " << u.periodic << " " << v.periodic);
      const Handle(Geom_BSplineSurface) surface = random_spline(u, v, random);
      SplineSurface evaluator(surface);
      double bounds[4];
      surface->Bounds(bounds[0], bounds[1], bounds[2], bounds[3]);
      double worst[3] = {};
      for (int i = 0; i < 60; ++i) {
        std::uniform_real_distribution<double> in_u(bounds[0] - 0.05, bounds[1] + 0.05), in_v(bounds[2], bounds[3]);
        const Vec2 uv{in_u(random), in_v(random)};
        gp_Pnt p;
        gp_Vec du, dv, duu, dvv, duv;
        surface->D2(uv.u, uv.v, p, du, dv, duu, dvv, duv);
        const SurfaceJet jet = evaluator.jet(uv);
        const SurfaceDerivatives d = evaluator.derivatives(uv);
        worst[0] = std::max({worst[0], error(jet.point, p.XYZ()), error(evaluator.point(uv), p.XYZ())});
        worst[1] = std::max(
            {worst[1], error(jet.du, du.XYZ()), error(jet.dv, dv.XYZ()), error(d.du, du.XYZ()), error(d.dv, dv.XYZ())});
        worst[2] =
            std::max({worst[2], error(jet.duu, duu.XYZ()), error(jet.duv, duv.XYZ()), error(jet.dvv, dvv.XYZ())});
      }
      CHECK(worst[0] < 1e-11);
      CHECK(worst[1] < 1e-9);
      CHECK(worst[2] < 1e-7);
    }
  }
}

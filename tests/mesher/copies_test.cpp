// Bodies of one shape in several places: meshed once, then moved, where sizes are the same.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "mesher/complexes.hpp"
#include "mesher/surface/copied_complexes.hpp"
#include "mesher/surface/surface_mesher.hpp"
#include "tests/mesher/options_of_size.hpp"
#include "tests/support/analytic_model.hpp"
#include "tests/support/placed_model.hpp"
#include "tests/threading/communicators.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"

using namespace tetloom;
using namespace tetloom::test_models;

namespace {

const std::vector<RigidMotion> kPlaces{{},
                                       turn_about({1, 2, 3}, 0.7, {7, 0, 0}),
                                       turn_about({0, -1, 1}, 2.1, {0, 8, 1}),
                                       turn_about({1, 0, 0}, 0, {0, 0, 9})};

std::unique_ptr<GeometricModel> cylinders() { return place_body(make_cylinder(1, 3), kPlaces); }

// What a place of a mesh has: its triangles and tets, with the numbers of its own points, and these.
struct Place {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::array<std::uint32_t, 4>> tets;
};

template <std::size_t N>
std::array<std::uint32_t, N> renumber(std::array<std::uint32_t, N> element, const Mesh& mesh,
                                      std::map<std::uint32_t, std::uint32_t>& numbers, Place& place) {
  for (std::uint32_t& v : element) {
    const auto [known, is_new] = numbers.emplace(v, static_cast<std::uint32_t>(place.points.size()));
    if (is_new) place.points.push_back(mesh.points[v]);
    v = known->second;
  }
  return element;
}

std::vector<Place> split_places(const Mesh& mesh, std::size_t faces_per_place, std::size_t count) {
  std::vector<Place> places(count);
  std::vector<std::map<std::uint32_t, std::uint32_t>> numbers(count);
  for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t) {
    const std::size_t p = mesh.tri_to_entity[t] / faces_per_place;
    places[p].triangles.push_back(renumber(mesh.tri_to_vert[t], mesh, numbers[p], places[p]));
  }
  for (std::size_t t = 0; t < mesh.tet_to_vert.size(); ++t) {
    const std::size_t p = mesh.tet_to_entity[t];
    places[p].tets.push_back(renumber(mesh.tet_to_vert[t], mesh, numbers[p], places[p]));
  }
  return places;
}

bool is_moved(const Place& first, const Place& other, const RigidMotion& motion) {
  return std::ranges::equal(first.points, other.points,
                            [&](const Vec3& a, const Vec3& b) { return distance(motion(a), b) < 1e-9; });
}

}  // namespace

TEST_CASE("Complexes of the same faces in other places are copies", "[copies]") {
  const auto model = cylinders();
  const std::vector<CopiedComplex> copies = find_copied_complexes(*model, find_complexes(model->topology()));
  REQUIRE(copies.size() == 3);
  for (std::size_t i = 0; i < copies.size(); ++i) {
    CHECK(distance(copies[i].motion({1, 2, 3}), kPlaces[i + 1]({1, 2, 3})) < 1e-12);
    CHECK(copies[i].faces.size() == 3);
    CHECK(copies[i].edges.size() == 3);
  }
}

TEST_CASE("Models that say nothing of places have no copies", "[copies]") {
  const std::vector<std::shared_ptr<const GeometricModel>> bodies{make_box({0, 0, 0}, {1, 1, 1}),
                                                                  make_box({2, 0, 0}, {3, 1, 1})};
  const auto model = combine(bodies);
  CHECK(find_copied_complexes(*model, find_complexes(model->topology())).empty());
}

TEST_CASE("Surfaces of copies are moved", "[copies]") {
  const auto model = cylinders();
  const TaskRunner runner(2, {});
  SurfaceMesher mesher(*model, SharedWork(runner));
  const SurfaceMeshResult surface = mesher.mesh(SizeField::uniform(0.4));
  CHECK(surface.errors.empty());
  CHECK(mesher.remeshed() == 3);
  const std::vector<Place> places = split_places(surface.mesh, 3, kPlaces.size());
  CHECK(places[0].triangles.size() > 200);
  for (std::size_t p = 1; p < places.size(); ++p) {
    CHECK(places[p].triangles == places[0].triangles);
    CHECK(is_moved(places[0], places[p], kPlaces[p]));
  }
}

TEST_CASE("A copy in which sizes are others is meshed for itself", "[copies]") {
  const auto model = cylinders();
  MeshOptions options = options_of_size(0.4);
  options.sizes.point_sizes.push_back({kPlaces[1]({0.9, 0, 1.5}), 0.05});
  const MeshResult result = make_mesh(*model, options);
  REQUIRE(result.status == MeshStatus::Ok);
  const std::vector<Place> places = split_places(result.mesh, 3, kPlaces.size());
  CHECK(places[1].tets.size() > places[0].tets.size() + 100);
  CHECK(places[3].tets == places[0].tets);
}

TEST_CASE("Volumes of copies are moved", "[copies]") {
  const auto model = cylinders();
  const MeshResult result = make_mesh(*model, options_of_size(0.4));
  REQUIRE(result.status == MeshStatus::Ok);
  CHECK(validate_mesh(result.mesh).valid());
  const std::vector<Place> places = split_places(result.mesh, 3, kPlaces.size());
  CHECK(places[0].tets.size() > 300);
  for (std::size_t p = 1; p < places.size(); ++p) {
    CHECK(places[p].triangles == places[0].triangles);
    CHECK(places[p].tets == places[0].tets);
    CHECK(is_moved(places[0], places[p], kPlaces[p]));
  }
}

TEST_CASE("Copies are the same on any number of ranks, and in parts", "[copies]") {
  const auto model = cylinders();
  MeshOptions options = options_of_size(0.25);
  options.tets_per_part = GENERATE(0.0, 500.0);
  const MeshResult whole = make_mesh(*model, options);
  REQUIRE(whole.status == MeshStatus::Ok);
  const auto communicator = make_communicator();
  const MeshResult ranks = make_mesh_on_ranks(*model, options, *communicator);
  REQUIRE(ranks.status == MeshStatus::Ok);
  if (communicator->rank() != 0) return;
  CHECK(ranks.mesh.points == whole.mesh.points);
  CHECK(ranks.mesh.tet_to_vert == whole.mesh.tet_to_vert);
  CHECK(ranks.mesh.tri_to_vert == whole.mesh.tri_to_vert);
}

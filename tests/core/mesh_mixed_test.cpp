#include <catch2/catch.hpp>
#include <set>

#include "core/mesh/validate.hpp"
#include "tests/support/mixed_mesh.hpp"

using namespace tetloom;

namespace {

std::string messages(const ValidationReport& report) {
  std::string text;
  for (const MeshProblem& problem : report.problems) text += problem.message + "; ";
  return text;
}

/// How many model entities of a dimension the points of a mesh lie on.
std::size_t entities_of(const Mesh& mesh, int dim) {
  std::set<std::uint32_t> seen;
  for (const ModelEntity& entity : mesh.point_to_entity)
    if (entity.dim == dim) seen.insert(entity.index);
  return seen.size();
}

}  // namespace

TEST_CASE("a box of tets is valid and lies on the model of a box") {
  for (unsigned seed = 0; seed < 5; ++seed) {
    INFO("seed " << seed);
    const Mesh one = test::make_tet_box(3, 4, 5, seed), two = test::make_tet_box(4, 3, 3, seed, true);
    CHECK(messages(validate_mesh(one)) == "");
    CHECK(messages(validate_mesh(two)) == "");
    CHECK(validate_mesh(two).interface_faces == 2 * 3 * 3);
    CHECK(std::array{entities_of(one, 0), entities_of(one, 1), entities_of(one, 2)} ==
          std::array<std::size_t, 3>{8, 12, 6});
    CHECK(std::array{entities_of(two, 0), entities_of(two, 1), entities_of(two, 2)} ==
          std::array<std::size_t, 3>{12, 20, 11});
  }
}

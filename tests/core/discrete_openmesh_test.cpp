// OpenMesh as an independent judge: its reader and half-edges must see the same surface.
#include <catch2/catch.hpp>

#include "core/discrete/judge/half_edge_judge.hpp"
#include "tests/core/discrete_shapes.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;
using namespace tetloom::shapes;

TEST_CASE("OpenMesh reads the same points and facets from an STL file as one face of a sphere has") {
  const TemporaryFolder folder;
  const auto path = folder.write("sphere.stl", binary_stl(make_sphere({1, 2, 3}, 2, 3)));
  const ModelDocument document = read_discrete_model(path);
  const Tessellation face = document.model->face_geometry(ModelFaceId(0))->tessellate(1, 1);
  const auto ours = judge_facets(face.points, face.tri_to_vert), theirs = judge_file(path);
  REQUIRE((ours && theirs));
  CHECK(ours->facets == 1280);
  CHECK(ours->open_edges == 0);
  CHECK(*ours == *theirs);
}

TEST_CASE("OpenMesh accepts every face as a manifold whose boundary is its loops") {
  Facets facets = make_cylinder(1, 3, 24, 6);
  append(facets, make_box({1, 0, 5}, {3, 1, 7}, 3)), append(facets, make_box({3, 0, 5}, {4, 1, 7}, 3));
  append(facets, make_torus(5, 0.5, 30, 10));
  const auto model = make_discrete_model(facets.points, facets.triangles, 0.7);
  for (std::size_t face = 0; face < model->topology().face_count(); ++face) {
    const Tessellation t = model->face_geometry(ModelFaceId(face))->tessellate(1, 1);
    const auto counts = judge_facets(t.points, t.tri_to_vert);
    REQUIRE(counts);
    std::size_t rim = 0;
    for (const ModelEntity& entity : t.classification) rim += entity.dim < 2;
    CHECK(counts->open_edges == rim);
    const auto loops = static_cast<long>(model->topology().face_to_loops[face].size());
    const auto euler = static_cast<long>(counts->vertices + counts->facets) - static_cast<long>(counts->edges);
    CHECK(euler == (loops == 0 ? 0 : 2 - loops));  // the torus is the face without loops
  }
}

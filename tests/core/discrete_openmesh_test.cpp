// OpenMesh as an independent judge: its reader and half-edges must see the same surface.
#include <catch2/catch.hpp>
#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include "core/discrete/discrete_model.hpp"
#include "tests/core/discrete_shapes.hpp"

using namespace tetloom;
using namespace tetloom::shapes;

namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
};
using HalfEdgeMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

/// Vertices, edges, facets and open edges of a face's tessellation as OpenMesh counts them.
std::array<std::size_t, 4> counts_of(const Tessellation& tessellation) {
  HalfEdgeMesh mesh;
  std::vector<HalfEdgeMesh::VertexHandle> handles;
  for (const Vec3& p : tessellation.points) handles.push_back(mesh.add_vertex({p.x, p.y, p.z}));
  for (const auto& [a, b, c] : tessellation.tri_to_vert) {
    REQUIRE(mesh.add_face(handles[a], handles[b], handles[c]).is_valid());
  }
  std::size_t open = 0;
  for (const auto edge : mesh.edges()) open += mesh.is_boundary(edge);
  return {mesh.n_vertices(), mesh.n_edges(), mesh.n_faces(), open};
}

}  // namespace

TEST_CASE("OpenMesh reads the same points and facets from an STL file as one face of a sphere has") {
  const TemporaryFolder folder;
  const auto path = folder.write("sphere.stl", binary_stl(make_sphere({1, 2, 3}, 2, 3)));
  HalfEdgeMesh mesh;
  REQUIRE(OpenMesh::IO::read_mesh(mesh, path.string()));
  const ModelDocument document = read_discrete_model(path);
  const Tessellation face = document.model->face_geometry(ModelFaceId(0))->tessellate(1, 1);
  CHECK(counts_of(face) == std::array<std::size_t, 4>{mesh.n_vertices(), mesh.n_edges(), mesh.n_faces(), 0});
}

TEST_CASE("OpenMesh accepts every face as a manifold whose boundary is its loops") {
  Facets facets = make_cylinder(1, 3, 24, 6);
  const Facets box = make_box({1, 0, 5}, {3, 1, 7}, 3), neighbour = make_box({3, 0, 5}, {4, 1, 7}, 3);
  append(facets, box), append(facets, neighbour), append(facets, make_torus(5, 0.5, 30, 10));
  const auto model = make_discrete_model(facets.points, facets.triangles, 0.7);
  for (std::size_t face = 0; face < model->topology().face_count(); ++face) {
    const Tessellation t = model->face_geometry(ModelFaceId(face))->tessellate(1, 1);
    const auto [vertices, edges, triangles, open] = counts_of(t);
    std::size_t rim = 0;
    for (const ModelEntity& entity : t.classification) rim += entity.dim < 2;
    CHECK(open == rim);
    const std::size_t loops = model->topology().face_to_loops[face].size();
    const long euler = static_cast<long>(vertices + triangles) - static_cast<long>(edges);
    const bool torus = loops == 0;
    CHECK(euler == (torus ? 0 : 2 - static_cast<long>(loops)));
  }
}

// Files that hold one mesh of tets are read by slices, which have together what the file has.
#include "core/io/file_slice.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <utility>

#include "tests/core/mesh_io_support.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tests/support/second_order_mesh.hpp"

using namespace tetloom;
using tetloom::test::error_of;
using tetloom::test::TemporaryFolder;

namespace {

const std::vector<std::string> kSlicedFormats{".vtu", ".msh", ".mesh", ".meshb"};

/// Two regions, with a point that no tet has and, for formats that have them, fields.
Mesh make_sliced_case(const std::string& extension) {
  Mesh mesh = test::make_tet_box(4, 3, 5, 3, true);
  mesh.points.insert(mesh.points.begin() + 7, Vec3{9, 9, 9});
  mesh.point_to_entity.insert(mesh.point_to_entity.begin() + 7, ModelEntity());
  const auto shift = [](auto& elements) {
    for (auto& element : elements)
      for (std::uint32_t& v : element) v += v >= 7 ? 1 : 0;
  };
  shift(mesh.tet_to_vert), shift(mesh.tri_to_vert), shift(mesh.edge_to_vert);
  if (extension != ".vtu" && extension != ".msh") return mesh;
  MeshField places{"places", 3, {}}, numbers{"numbers", 1, {}};
  for (const Vec3& p : mesh.points) places.values.insert(places.values.end(), {p.x, p.y, p.z});
  for (std::size_t i = 0; i < mesh.tet_to_vert.size(); ++i) numbers.values.push_back(static_cast<double>(i));
  mesh.point_fields = {places}, mesh.cell_fields = {numbers};
  return mesh;
}

/// By the points of the file, ascending, and the entity.
template <std::size_t N>
using SidesOfFile = std::multiset<std::pair<std::array<std::uint64_t, N>, std::uint32_t>>;

template <std::size_t N>
SidesOfFile<N> sides_of_file(const std::vector<std::array<std::uint32_t, N>>& elements,
                             const std::vector<std::uint32_t>& entities, const std::vector<std::uint64_t>& ids) {
  SidesOfFile<N> found;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    std::array<std::uint64_t, N> verts;
    for (std::size_t j = 0; j < N; ++j) verts[j] = ids.empty() ? elements[i][j] : ids[elements[i][j]];
    std::ranges::sort(verts);
    found.emplace(verts, entities[i]);
  }
  return found;
}

/// Of a slice: points and their fields are those of the file.
void check_slice_points(const MeshPiece& piece, const Mesh& whole) {
  REQUIRE(piece.global_ids.size() == piece.mesh.points.size());
  REQUIRE(piece.mesh.point_to_entity.size() == piece.mesh.points.size());
  CHECK(std::ranges::is_sorted(piece.global_ids));
  for (std::size_t v = 0; v < piece.global_ids.size(); ++v) {
    const std::uint64_t id = piece.global_ids[v];
    REQUIRE(piece.mesh.points[v] == whole.points[id]);
    REQUIRE(piece.mesh.point_to_entity[v] == whole.point_to_entity[id]);
    for (std::size_t f = 0; f < whole.point_fields.size(); ++f)
      for (std::size_t c = 0; c < 3; ++c)
        REQUIRE(piece.mesh.point_fields[f].values[3 * v + c] == whole.point_fields[f].values[3 * id + c]);
  }
}

template <std::size_t N>
void check_slice_sides(const SidesOfFile<N>& sides, const SidesOfFile<N>& all, const std::vector<std::uint64_t>& ids,
                       const Mesh& slice) {
  for (const auto& side : sides) {
    REQUIRE(all.count(side) == 1);
    const auto has_it = [&](const auto& tet) {
      return std::ranges::all_of(side.first, [&](std::uint64_t id) {
        return std::ranges::any_of(tet, [&](std::uint32_t v) { return ids[v] == id; });
      });
    };
    REQUIRE(std::ranges::any_of(slice.tet_to_vert, has_it));
  }
}

}  // namespace

TEST_CASE("slices of a file have together what the file has") {
  for (const std::string& extension : kSlicedFormats) {
    INFO(extension);
    const TemporaryFolder folder;
    const auto path = folder / ("mesh" + extension);
    write_mesh(make_sliced_case(extension), path);
    REQUIRE(has_slices(path));
    const Mesh whole = read_mesh(path);
    const auto all_triangles = sides_of_file(whole.tri_to_vert, whole.tri_to_entity, {});
    const auto all_edges = sides_of_file(whole.edge_to_vert, whole.edge_to_entity, {});
    for (const std::size_t count : {1, 2, 3, 11}) {
      CAPTURE(count);
      std::vector<std::array<std::uint64_t, 4>> tets;
      std::vector<std::uint32_t> regions;
      std::vector<double> numbers;
      auto triangles = SidesOfFile<3>();
      auto edges = SidesOfFile<2>();
      for (std::size_t index = 0; index < count; ++index) {
        const std::optional<FileSlice> slice = read_slice(path, index, count);
        REQUIRE(slice);
        CHECK(slice->file.points == whole.points.size());
        CHECK(slice->file.tets == whole.tet_to_vert.size());
        CHECK(slice->file.triangles == whole.tri_to_vert.size());
        CHECK(slice->file.edges == whole.edge_to_vert.size());
        const auto& [mesh, ids] = slice->piece;
        check_slice_points(slice->piece, whole);
        CHECK(mesh.face_to_sides.size() == whole.face_to_sides.size());
        for (const auto& [a, b, c, d] : mesh.tet_to_vert) tets.push_back({ids[a], ids[b], ids[c], ids[d]});
        regions.insert(regions.end(), mesh.tet_to_entity.begin(), mesh.tet_to_entity.end());
        if (!whole.cell_fields.empty())
          numbers.insert(numbers.end(), mesh.cell_fields[0].values.begin(), mesh.cell_fields[0].values.end());
        const auto own_triangles = sides_of_file(mesh.tri_to_vert, mesh.tri_to_entity, ids);
        const auto own_edges = sides_of_file(mesh.edge_to_vert, mesh.edge_to_entity, ids);
        check_slice_sides(own_triangles, all_triangles, ids, mesh), check_slice_sides(own_edges, all_edges, ids, mesh);
        for (const auto& triangle : own_triangles)
          if (triangles.count(triangle) == 0) triangles.insert(triangle);
        for (const auto& edge : own_edges)
          if (edges.count(edge) == 0) edges.insert(edge);
      }
      REQUIRE(tets.size() == whole.tet_to_vert.size());
      for (std::size_t t = 0; t < tets.size(); ++t) REQUIRE(std::ranges::equal(tets[t], whole.tet_to_vert[t]));
      CHECK(regions == whole.tet_to_entity);
      CHECK((triangles == all_triangles));
      CHECK((edges == all_edges));
      if (!whole.cell_fields.empty()) CHECK(numbers == whole.cell_fields[0].values);
    }
  }
}

TEST_CASE("a VTU file of several pieces, as text, is read by slices") {
  const auto piece = [](const std::string& apex, const std::string& value) {
    return R"(<Piece NumberOfPoints="5" NumberOfCells="3"><PointData><DataArray type="Float64" Name="heat" format="ascii">
      1 2 3 4 5</DataArray></PointData><CellData><DataArray type="Float64" Name="load" format="ascii">)" +
           value +
           R"( 8 9</DataArray></CellData><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">
      7 7 7  0 0 0  1 0 0  0 1 0  )" +
           apex + R"(</DataArray></Points><Cells><DataArray type="Int32" Name="connectivity" format="ascii">
      1 2 3 4  1 2 3  2</DataArray><DataArray type="Int32" Name="offsets" format="ascii">4 7 8</DataArray>
      <DataArray type="UInt8" Name="types" format="ascii">10 5 1</DataArray></Cells></Piece>)";
  };
  const TemporaryFolder folder;
  test::write_file(folder / "two.vtu", R"(<VTKFile type="UnstructuredGrid"><UnstructuredGrid>)" + piece("0 0 1", "3") +
                                           piece("0 0 2", "4") + "</UnstructuredGrid></VTKFile>");
  const Mesh whole = read_mesh(folder / "two.vtu");
  const std::optional<FileSlice> slice = read_slice(folder / "two.vtu", 1, 2);
  REQUIRE(slice);
  const auto& [mesh, ids] = slice->piece;
  CHECK(ids == std::vector<std::uint64_t>{6, 7, 8, 9});
  CHECK(mesh.points[3] == Vec3{0, 0, 2});
  CHECK((mesh.tet_to_vert == std::vector<std::array<std::uint32_t, 4>>{{0, 1, 2, 3}}));
  CHECK((mesh.tri_to_vert == std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}}));
  CHECK(mesh.point_to_entity[1] == whole.point_to_entity[7]);
  CHECK(mesh.point_fields[0].values == std::vector<double>{2, 3, 4, 5});
  CHECK(mesh.cell_fields[0].values == std::vector<double>{4});
}

// Two tets on a triangle, with a corner, nodes in any order from `first_node` on, and values on some of them.
std::string old_msh(int first_node, const std::string& last_tet, const std::string& view) {
  const auto node = [&](int i) { return std::to_string(first_node + i); };
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n" + node(3) + " 0 0 1\n" + node(0) + " 0 0 0\n" + node(2) +
         " 0 1 0\n" + node(1) + " 1 0 0\n" + node(4) + " 0 0 -1\n$EndNodes\n$Elements\n4\n1 15 2 0 3 " + node(0) +
         "\n2 2 2 0 4 " + node(0) + " " + node(1) + " " + node(2) + "\n3 4 2 0 1 " + node(0) + " " + node(1) + " " +
         node(2) + " " + node(3) + "\n" + last_tet + " 4 2 0 2 " + node(0) + " " + node(2) + " " + node(1) + " " +
         node(4) + "\n$EndElements\n" + view;
}

std::string msh_view(const std::string& section, const std::string& values) {
  return "$" + section + "\n1\n\"heat\"\n1\n0\n3\n0\n1\n2\n" + values + "$End" + section + "\n";
}

TEST_CASE("an MSH file of version 2.2, with views of some nodes and elements, is read by slices") {
  const TemporaryFolder folder;
  test::write_file(folder / "two.msh",
                   old_msh(7, "4", msh_view("NodeData", "7 70\n11 11\n") + msh_view("ElementData", "2 5\n3 30\n")));
  const Mesh whole = read_mesh(folder / "two.msh");
  for (const std::size_t index : {0, 1}) {
    const std::optional<FileSlice> slice = read_slice(folder / "two.msh", index, 2);
    REQUIRE(slice);
    const auto& [mesh, ids] = slice->piece;
    CHECK(ids == (index == 0 ? std::vector<std::uint64_t>{0, 1, 2, 3} : std::vector<std::uint64_t>{0, 1, 2, 4}));
    for (std::size_t v = 0; v < 4; ++v) CHECK(mesh.points[v] == whole.points[ids[v]]);
    CHECK(mesh.point_to_entity[0] == ModelEntity(0, 2));
    CHECK(mesh.tet_to_entity == std::vector<std::uint32_t>{static_cast<std::uint32_t>(index)});
    CHECK(mesh.tri_to_entity == std::vector<std::uint32_t>{3});
    CHECK((slice->file.points == 5 && slice->file.tets == 2 && slice->file.triangles == 1));
    // All slices have all fields, and no number where the file has none.
    REQUIRE((mesh.point_fields.size() == 1 && mesh.cell_fields.size() == 1));
    CHECK(mesh.point_fields[0].values[0] == 70);
    CHECK((index == 1 ? mesh.point_fields[0].values[3] == 11 : std::isnan(mesh.point_fields[0].values[3])));
    CHECK((index == 0 ? mesh.cell_fields[0].values[0] == 30 : std::isnan(mesh.cell_fields[0].values[0])));
  }
  CHECK(whole.cell_fields[0].values[0] == 30);
}

TEST_CASE("an MSH file whose tags have gaps, or stand twice, is not read by slices") {
  const TemporaryFolder folder;
  const auto path = folder / "mesh.msh";
  test::write_file(path, old_msh(7, "9", ""));
  CHECK_FALSE(read_slice(path, 0, 2));
  CHECK(read_mesh(path).tet_to_vert.size() == 2);
  std::string twice = old_msh(1, "4", "");
  twice.replace(twice.find("\n4 0 0 1"), 2, "\n5");  // tags 1, 2, 3, 5, 5
  test::write_file(path, twice);
  CHECK(error_of([&] { read_mesh(path); }).code == ErrorCode::InputUnreadable);
  CHECK(error_of([&] { read_slice(path, 1, 2); }).code == ErrorCode::InputUnreadable);
  std::string unknown = old_msh(1, "4", msh_view("NodeData", "1 1\n6 6\n"));
  test::write_file(path, unknown);
  CHECK(error_of([&] { read_slice(path, 0, 2); }).code == ErrorCode::InputUnreadable);
  write_mesh(test::with_mid_nodes(test::make_tet_box(2, 2, 2)), path);
  CHECK_FALSE(read_slice(path, 0, 2));
}

TEST_CASE("a slice takes no memory for points that a file only claims") {
  const TemporaryFolder folder;
  test::write_file(folder / "claims.vtu", R"(<VTKFile type="UnstructuredGrid"><UnstructuredGrid>
      <Piece NumberOfPoints="4000000000" NumberOfCells="1"><Points><DataArray type="Float64" NumberOfComponents="3"
      format="ascii">0 0 0  1 0 0  0 1 0  0 0 1</DataArray></Points><Cells>
      <DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 3999999999</DataArray>
      <DataArray type="Int32" Name="offsets" format="ascii">4</DataArray>
      <DataArray type="UInt8" Name="types" format="ascii">10</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>)");
  CHECK(error_of([&] { read_slice(folder / "claims.vtu", 0, 1); }).code == ErrorCode::InputUnreadable);
}

TEST_CASE("what is no mesh of tets is not read by slices") {
  const TemporaryFolder folder;
  for (const std::string& extension : kSlicedFormats) {
    INFO(extension);
    write_mesh(test::make_mixed_box(4, 3, 5, 7, true), folder / ("mixed" + extension));
    CHECK_FALSE(read_slice(folder / ("mixed" + extension), 0, 2));
    write_mesh(test::make_tet_box(1, 1, 1, 3, false), folder / ("few" + extension));
    CHECK_FALSE(read_slice(folder / ("few" + extension), 5, 7));
    CHECK(read_slice(folder / ("few" + extension), 5, 6));
  }
  const std::string points = "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n";
  test::write_file(folder / "beyond.mesh", points + "Tetrahedra\n1\n1 2 3 5 1\nEnd\n");
  CHECK_FALSE(read_slice(folder / "beyond.mesh", 0, 1));
  test::write_file(folder / "twice.mesh", points + "Tetrahedra\n1\n1 2 3 4 1\nTetrahedra\n1\n1 3 2 4 1\nEnd\n");
  CHECK_FALSE(read_slice(folder / "twice.mesh", 0, 2));
  CHECK_FALSE(has_slices("mesh.pvtu"));
}

TEST_CASE("files that are missing or cut off have no slices, and a reader of slices can be cancelled") {
  for (const std::string& extension : kSlicedFormats) {
    INFO(extension);
    const TemporaryFolder folder;
    const auto path = folder / ("mesh" + extension);
    CHECK(error_of([&] { read_slice(path, 0, 2); }).code == ErrorCode::InputUnreadable);
    write_mesh(make_sliced_case(extension), path);
    CancelToken cancel;
    cancel.cancel();
    CHECK(error_of([&] { read_slice(path, 0, 2, &cancel); }).code == ErrorCode::Cancelled);
    const std::string content = test::file_content(path);
    for (const std::size_t size : {content.size() / 10, content.size() / 2, content.size() * 9 / 10}) {
      CAPTURE(size);
      test::write_file(path, content.substr(0, size));
      CHECK(error_of([&] { read_slice(path, 1, 2); }).code == ErrorCode::InputUnreadable);
    }
  }
}

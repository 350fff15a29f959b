// Files that are damaged, foreign or hostile: always an Error with a reason, never a crash.
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <random>

#include "tests/core/mesh_fixtures.hpp"
#include "tests/core/mesh_io_support.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"

using namespace tetloom;
using test::content_of;
using test::error_for;
using test::error_of;
using test::file_content;
using test::survive;
using test::TemporaryFolder;
using test::write_file;

namespace {

constexpr std::array<const char*, 5> kExtensions{".vtu", ".msh", ".mesh", ".meshb", ".stl"};

Diagnostic reading_error(const std::filesystem::path& path) {
  return error_of([&] { static_cast<void>(read_mesh(path)); });
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t place = text.find(from);
  REQUIRE(place != std::string::npos);
  return text.replace(place, from.size(), to);
}

}  // namespace

TEST_CASE("what is no file of meshes is refused with the reason") {
  const TemporaryFolder folder;
  for (const char* extension : kExtensions) {
    INFO(extension);
    const auto path = folder / test::joined("x", extension);
    const auto refuse = [&](const std::string& reason) {
      const Diagnostic error = reading_error(path);
      CHECK(error.code == ErrorCode::InputUnreadable);
      CHECK_THAT(error.message, Catch::Contains(reason) && Catch::Contains(test::joined("x", extension)));
      std::filesystem::remove(path);
    };
    refuse("No such file or directory");
    std::filesystem::create_directory(path);
    refuse("Is a directory");
    write_file(path, "");
    refuse("empty");
    REQUIRE(::mkfifo(path.c_str(), 0600) == 0);
    refuse("no regular file");
    write_file(path, "no mesh at all\n");
    refuse("");
    write_file(path, content_of(test::make_box(1, 1, 1), std::string(extension) == ".vtu" ? ".msh" : ".vtu"));
    refuse("");
  }
}

TEST_CASE("a file cut off anywhere is refused") {
  Mesh mesh = test::make_box(2, 1, 1, true);
  test::decorate(mesh);
  const TemporaryFolder folder;
  for (const char* extension : kExtensions) {
    INFO(extension);
    const std::string content = content_of(mesh, extension);
    const auto path = folder / test::joined("cut", extension);
    for (std::size_t size = 1; size < content.size(); ++size) {
      write_file(path, content.substr(0, size));
      try {
        // Of the end mark itself a few bytes may be missing, but nothing of the mesh.
        if (mesh_digest(read_mesh(path)) != mesh_digest(mesh) || size + 5 < content.size())
          FAIL_CHECK("accepted " << size << " of " << content.size() << " bytes");
      } catch (const Error& error) {
        if (error.code() != ErrorCode::InputUnreadable) FAIL_CHECK(size << ": " << error.what());
      }
    }
  }
}

TEST_CASE("random bytes are refused") {
  std::mt19937 random(1);
  INFO("seed 1");
  const TemporaryFolder folder;
  for (const char* extension : kExtensions)
    for (int round = 0; round < 50; ++round) {
      std::string content(random() % 3000 + 1, '\0');
      for (char& c : content) c = static_cast<char>(random());
      const auto path = folder / test::joined("random", extension);
      write_file(path, content);
      const Diagnostic error = reading_error(path);
      CHECK(error.code == ErrorCode::InputUnreadable);
    }
}

TEST_CASE("damaged files of all formats never do harm") {
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  INFO("seed " << kSeed);
  Mesh mesh = test::make_box(2, 2, 1, true);
  test::decorate(mesh);
  const TemporaryFolder folder;
  for (const char* extension : kExtensions) {
    const std::string content = content_of(mesh, extension);
    for (int round = 0; round < 1500; ++round) {
      std::string damaged = content;
      const int changes = 1 + static_cast<int>(random() % 3);
      for (int change = 0; change < changes; ++change) {
        const std::size_t at = random() % damaged.size();
        switch (random() % 4) {
          case 0: damaged[at] = static_cast<char>(random()); break;
          case 1: damaged[at] = static_cast<char>(damaged[at] ^ (1 << random() % 8)); break;
          case 2: damaged.erase(at, random() % 9); break;
          case 3: damaged.replace(at, std::min<std::size_t>(8, damaged.size() - at), 8, '\xff'); break;
        }
        if (damaged.empty()) damaged.assign(1, 'x');
      }
      const auto path = folder / test::joined("damaged", extension);
      write_file(path, damaged);
      survive(path);
    }
  }
}

TEST_CASE("counts that the file does not back are refused before memory is allocated for them") {
  const std::string huge = "9000000000000000000";
  for (const std::string section : {"Vertices", "Triangles", "Tetrahedra", "Corners"}) {
    INFO(section);
    const Diagnostic error =
        error_for(".mesh", "MeshVersionFormatted 2\nDimension 3\n" + section + "\n" + huge + "\n0 0 0 1\nEnd\n");
    CHECK(error.code == ErrorCode::InputUnreadable);
    CHECK_THAT(error.message, Catch::Contains("exceeds the file"));
  }
  const std::string format = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
  CHECK_THAT(error_for(".msh", format + "$Nodes\n1 " + huge + " 1 2\n2 1 0 2\n1\n2\n0 0 0\n1 0 0\n$EndNodes\n").message,
             Catch::Contains("exceeds the file"));
  CHECK_THAT(error_for(".msh", format + "$Nodes\n1 2 1 2\n2 1 0 " + huge + "\n1\n2\n0 0 0\n1 0 0\n$EndNodes\n").message,
             Catch::Contains("exceeds the file"));
  CHECK_THAT(error_for(".msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + huge + "\n$EndNodes\n").message,
             Catch::Contains("exceeds the file"));
  const std::string vtu = content_of(test::make_box(1, 1, 1), ".vtu");
  CHECK(error_for(".vtu", replaced(vtu, "NumberOfPoints=\"8\"", "NumberOfPoints=\"" + huge + "\"")).code !=
        ErrorCode::OutOfMemory);
}

TEST_CASE("pieces that all claim the same data are refused before they fill the memory") {
  std::string numbers;
  for (int i = 0; i < 30000; ++i) numbers += std::string(1, '\0');
  std::string pieces;
  for (int i = 0; i < 400; ++i)
    pieces +=
        "<Piece NumberOfPoints='1250' NumberOfCells='0'><Points><DataArray type='Float64' Name='P' format='appended' "
        "offset='0'/></Points></Piece>";
  const Diagnostic error =
      error_for(".vtu", "<VTKFile type='UnstructuredGrid' header_type='UInt64'><UnstructuredGrid>" + pieces +
                            "</UnstructuredGrid><AppendedData encoding=\"raw\">_" +
                            std::string("\x30\x75\0\0\0\0\0\0", 8) + numbers + "</AppendedData></VTKFile>");
  CHECK(error.code == ErrorCode::InputUnreadable);
  CHECK_THAT(error.message, Catch::Contains("more data than the file can hold"));
}

TEST_CASE("numbers beyond the range of doubles become the nearest ones") {
  const TemporaryFolder folder;
  write_file(
      folder / "a.mesh",
      "MeshVersionFormatted 2\nDimension 3\nVertices\n2\n1e-999 -1.5e999 2e-310 0\n0 0 0 0\nEdges\n1\n1 2 1\nEnd\n");
  const Mesh mesh = read_mesh(folder / "a.mesh");
  CHECK(mesh.points[0].x == 0);
  CHECK(mesh.points[0].y == -HUGE_VAL);
  CHECK(mesh.points[0].z == 2e-310);
}

TEST_CASE("indices out of range are refused with the element") {
  const std::string start = "MeshVersionFormatted 2\nDimension 3\nVertices\n3\n0 0 0 0\n1 0 0 0\n0 1 0 0\n";
  for (const char* index : {"0", "4", "4294967296", "18446744073709551615"}) {
    INFO(index);
    const Diagnostic error = error_for(".mesh", start + "Triangles\n2\n1 2 3 1\n1 2 " + index + " 1\nEnd\n");
    CHECK(error.code == ErrorCode::InputUnreadable);
    CHECK_THAT(error.message, Catch::Contains("triangle 2"));
  }
  CHECK_THAT(error_for(".mesh", start + "Corners\n1\n9\nTriangles\n1\n1 2 3 1\nEnd\n").message,
             Catch::Contains("corner"));
  const std::string msh =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n10 0 0 0\n20 1 0 0\n30 0 1 0\n$EndNodes\n$Elements\n1\n";
  CHECK_THAT(error_for(".msh", msh + "1 2 2 0 1 10 20 31\n$EndElements\n").message, Catch::Contains("triangle 1"));
  CHECK(error_for(".msh", msh + "1 15 2 0 1 31\n$EndElements\n").code != ErrorCode::Internal);
}

TEST_CASE("errors in text name the line") {
  const Diagnostic error = error_for(".mesh", "MeshVersionFormatted 2\nDimension 3\nVertices\n1\n0 zero 0 0\nEnd\n");
  CHECK_THAT(error.message, Catch::Contains("'zero'") && Catch::Contains("line 5"));
}

TEST_CASE("elements that a mesh cannot hold are refused by name") {
  const auto refuse = [](const Diagnostic& error, const std::string& name) {
    CHECK(error.code == ErrorCode::InputUnsuitable);
    CHECK_THAT(error.message, Catch::Contains(name));
  };
  refuse(error_for(".mesh", "MeshVersionFormatted 2\nDimension 3\nHexahedraQ2\n1\n1 2 3 4 5 6 7 8 0\nEnd\n"),
         "HexahedraQ2");
  refuse(error_for(".mesh", "MeshVersionFormatted 2\nDimension 3\nTetrahedraP2\n1\n1 2 3\nEnd\n"), "TetrahedraP2");
  refuse(error_for(".msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Elements\n1 1 1 1\n3 1 29 1\n1 2\n$EndElements\n"),
         "third-order tetrahedron");
  refuse(error_for(".msh", "$MeshFormat\n4.0 0 8\n$EndMeshFormat\n"), "version 4.0");
  refuse(
      error_for(".vtu",
                "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"1\" "
                "NumberOfCells=\"1\"><Points><DataArray type=\"Float32\" format=\"ascii\">0 0 0</DataArray></Points>"
                "<Cells><DataArray type=\"Int32\" Name=\"connectivity\">0</DataArray>"
                "<DataArray type=\"Int32\" Name=\"offsets\">1</DataArray>"
                "<DataArray type=\"UInt8\" Name=\"types\">11</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>"),
      "voxel");
  refuse(error_for(".vtu", "<VTKFile type=\"PolyData\"></VTKFile>"), "PolyData");
  refuse(error_for(".mesh", "MeshVersionFormatted 2\nDimension 3\nVertices\n1\n0 0 0 0\nEnd\n"), "no edges");
}

TEST_CASE("keywords that are of no interest are passed over") {
  const TemporaryFolder folder;
  write_file(folder / "a.mesh",
             "# a comment Vertices 7\nMeshVersionFormatted 1\nDimension\n3\nIdentifier\n\"G1 b\"\nNormals\n1\n0 0 1\n"
             "Vertices\n3\n0 0 0 1\n1 0 0 5\n0 1 0 0 # trailing\nRidges 1 1 Corners 1 2\nTangents\n1\nnan inf -1e5\n"
             "Quadrilaterals\n0\nTriangles\n1\n1 2 3 -4\nEdges 1\n1 2 6\nEnd");
  const Mesh mesh = read_mesh(folder / "a.mesh");
  CHECK(mesh.points.size() == 3);
  CHECK(mesh.tri_to_entity == std::vector<std::uint32_t>{ModelFaceId::kNone});
  CHECK(mesh.edge_to_entity == std::vector<std::uint32_t>{5});
  CHECK(mesh.point_to_entity[0] == ModelEntity(1, 5));
  CHECK(mesh.point_to_entity[1] == ModelEntity(0, 4));
  CHECK_FALSE(mesh.point_to_entity[2].valid());
}

TEST_CASE("VTU files in several pieces are read") {
  const TemporaryFolder folder;
  const auto piece = [](const std::string& x) {
    return "<Piece NumberOfPoints='3' NumberOfCells='2'><Points><DataArray type='Float32' NumberOfComponents='3'>" + x +
           " 0 0 1 0 0 0 1 0</DataArray></Points><Cells><DataArray type='Int64' Name='connectivity'>0 1 2 1</DataArray>"
           "<DataArray type='Int64' Name='offsets'>3 4</DataArray><DataArray type='UInt8' Name='types'>5 1</DataArray>"
           "</Cells><CellData><DataArray type='Int32' Name='material'>4 2</DataArray></CellData></Piece>";
  };
  write_file(folder / "a.vtu", "<?xml version='1.0'?><!-- x --><VTKFile type='UnstructuredGrid'><UnstructuredGrid>" +
                                   piece("0") + piece("7.5") + "</UnstructuredGrid></VTKFile>");
  const Mesh mesh = read_mesh(folder / "a.vtu");
  CHECK(mesh.points.size() == 6);
  CHECK(mesh.points[3].x == 7.5);
  CHECK(mesh.tri_to_vert == std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {3, 4, 5}});
  CHECK(mesh.point_to_entity[4] == ModelEntity(0, 1));
  CHECK(mesh.point_to_entity[5] == ModelEntity(2, 3));
}

namespace {

template <class Number>
void append_big_endian(std::string& bytes, Number value) {
  char raw[sizeof(Number)];
  std::memcpy(raw, &value, sizeof(Number));
  std::reverse(raw, raw + sizeof(Number));
  bytes.append(raw, sizeof(Number));
}

template <class Number>
std::string big_endian(std::initializer_list<Number> values) {
  std::string bytes;
  for (const Number value : values) append_big_endian(bytes, value);
  return bytes;
}

void check_is_one_triangle(const Mesh& mesh) {
  CHECK(mesh.points == std::vector<Vec3>{{0, 0, 0}, {2, 0, 0}, {0, 0.1, 0}});
  CHECK(mesh.tri_to_vert == std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}});
}

}  // namespace

TEST_CASE("files of the other byte order are read") {
  const TemporaryFolder folder;
  std::string meshb = big_endian<std::int32_t>({1, 2, 3, 20, 3, 4, 20 + 12 + 3 * 28, 3});
  for (const Vec3& point : {Vec3{0, 0, 0}, Vec3{2, 0, 0}, Vec3{0, 0.1, 0}})
    meshb += big_endian<double>({point.x, point.y, point.z}) + big_endian<std::int32_t>({0});
  meshb += big_endian<std::int32_t>({6, 116 + 28, 1, 1, 2, 3, 8, 54, 0});
  write_file(folder / "a.meshb", meshb);
  const Mesh mesh = read_mesh(folder / "a.meshb");
  check_is_one_triangle(mesh);
  CHECK(mesh.tri_to_entity == std::vector<std::uint32_t>{7});

  const auto array = [](const std::string& type, const std::string& name, int offset) {
    return "<DataArray type='" + type + "' Name='" + name + "' format='appended' offset='" + std::to_string(offset) +
           "'/>";
  };
  write_file(folder / "a.vtu",
             "<VTKFile type='UnstructuredGrid' byte_order='BigEndian'><UnstructuredGrid>"
             "<Piece NumberOfPoints='3' NumberOfCells='1'><Points>" +
                 array("Float64", "Points", 0) + "</Points><Cells>" + array("Int16", "connectivity", 76) +
                 array("Int32", "offsets", 86) + array("UInt8", "types", 94) +
                 "</Cells></Piece></UnstructuredGrid><AppendedData encoding=\"raw\">_" +
                 big_endian<std::int32_t>({72}) + big_endian<double>({0, 0, 0, 2, 0, 0, 0, 0.1, 0}) +
                 big_endian<std::int32_t>({6}) + big_endian<std::int16_t>({0, 1, 2}) +
                 big_endian<std::int32_t>({4, 3, 1}) + "\x05</AppendedData></VTKFile>");
  check_is_one_triangle(read_mesh(folder / "a.vtu"));
}

TEST_CASE("reading stops when it is cancelled") {
  const TemporaryFolder folder;
  CancelToken cancel;
  cancel.cancel();
  for (const char* extension : kExtensions) {
    const auto path = folder / test::joined("mesh", extension);
    write_mesh(test::make_box(2, 2, 2), path);
    CHECK(error_of([&] { static_cast<void>(read_mesh(path, &cancel)); }).code == ErrorCode::Cancelled);
  }
}

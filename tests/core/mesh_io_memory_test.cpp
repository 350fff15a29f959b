// What reading asks of memory: in proportion to the file, however many blocks it has and whatever its tags are. This
// program counts what it allocates.
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <new>
#include <string>

#include "tests/core/mesh_io_support.hpp"
#include "tetloom/io.hpp"

namespace {
std::atomic<std::size_t> allocated{0};
}

void* operator new(std::size_t size) {
  allocated += size;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

using namespace tetloom;

namespace {

const std::string kPoints = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";

/// Text MSH of one tet in each of so many blocks.
std::string msh(int blocks) {
  std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n" + kPoints +
                     "$EndNodes\n$Elements\n" + std::to_string(blocks) + " " + std::to_string(blocks) + " 1 " +
                     std::to_string(blocks) + "\n";
  for (int i = 1; i <= blocks; ++i) text += "3 1 4 1\n" + std::to_string(i) + " 1 2 3 4\n";
  return text + "$EndElements\n";
}

std::string medit(int blocks) {
  std::string text = "MeshVersionFormatted 2\nDimension 3\nVertices 4\n0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 1\n";
  for (int i = 0; i < blocks; ++i) text += "Tetrahedra 1\n1 2 3 4 1\n";
  return text + "End\n";
}

std::string vtu(int blocks) {
  std::string text = "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\"><UnstructuredGrid>\n";
  for (int i = 0; i < blocks; ++i)
    text +=
        "<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><Points><DataArray type=\"Float64\" "
        "NumberOfComponents=\"3\" format=\"ascii\">" +
        kPoints +
        "</DataArray></Points><Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 "
        "3</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4</DataArray><DataArray "
        "type=\"UInt8\" Name=\"types\" format=\"ascii\">10</DataArray></Cells></Piece>\n";
  return text + "</UnstructuredGrid></VTKFile>\n";
}

/// Bytes that are asked for to read a file of that text.
std::size_t bytes_to_read(const std::string& extension, const std::string& text, Mesh& mesh) {
  const test::TemporaryFolder folder;
  const auto path = folder / test::joined("mesh", extension);
  test::write_file(path, text);
  const std::size_t before = allocated;
  mesh = read_mesh(path);
  return allocated - before;
}

}  // namespace

TEST_CASE("a file of many blocks is read in memory and time in proportion to their number") {
  struct Format {
    const char* extension;
    std::string (*text)(int blocks);
  };
  for (const Format& format : {Format{".msh", msh}, Format{".mesh", medit}, Format{".vtu", vtu}}) {
    CAPTURE(format.extension);
    Mesh few, many;
    const std::size_t small = bytes_to_read(format.extension, format.text(500), few);
    const std::size_t large = bytes_to_read(format.extension, format.text(8000), many);
    CHECK(few.tet_to_vert.size() == 500);
    CHECK(many.tet_to_vert.size() == 8000);
    // 16 times as much, but for vectors that are up to twice as long as they have to be.
    CHECK(large < 3 * 16 * small);
  }
}

TEST_CASE("tables by tag take memory in proportion to the file") {
  const std::string names = "$PhysicalNames\n1\n3 1 \"part\"\n$EndPhysicalNames\n";
  const auto file = [&](const std::string& tag) {
    return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + names + "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n" +
           "$EndNodes\n$Elements\n1\n1 4 2 1 " + tag + " 1 2 3 4\n$EndElements\n";
  };
  Mesh mesh;
  bytes_to_read(".msh", file("9999"), mesh);
  REQUIRE(mesh.entities[3].size() == 9999);
  CHECK(mesh.entities[3].back().name == "part");
  for (const char* tag : {"10001", "999999", "2147483647"}) {
    CAPTURE(tag);
    CHECK(bytes_to_read(".msh", file(tag), mesh) < std::size_t{2} << 20);
    CHECK(mesh.tet_to_entity[0] == static_cast<std::uint32_t>(std::stoul(tag)) - 1);
  }
}

#include "threading/parts/tet_packet.hpp"

#include <catch2/catch.hpp>

#include <algorithm>
#include <string>
#include <vector>

#include "core/tets/tet_mesh.hpp"
#include "tests/support/tet_fixtures.hpp"

using namespace tetloom;
using tets::FaceCode;
using tets::TetMesh;

namespace {

// Keys descend, and do not fit in 32 bits.
std::uint64_t key_of(std::uint32_t vert) { return (std::uint64_t{1} << 40) - vert; }

// Links by place in the packet, and by number of the tet where it is not in the packet.
constexpr std::uint32_t kByNumber = 1u << 20;

Bytes pack(const TetMesh& mesh, TetPacker<TetMesh>& packer, const std::vector<std::uint32_t>& tets) {
  packer.begin(tets);
  MessageWriter writer;
  packer.put(writer, key_of);
  packer.put_links(writer, [&](FaceCode face) {
    const FaceCode behind = mesh.behind(face);
    if (!behind.valid()) return behind;
    const auto at = std::ranges::find(tets, behind.tet());
    return behind.of_tet(at == tets.end() ? behind.tet() | kByNumber : static_cast<std::uint32_t>(at - tets.begin()));
  });
  writer.put_each(tets, [](std::uint32_t tet) { return tet; });
  return writer.take();
}

struct Joined {
  TetMesh mesh;
  std::vector<std::uint64_t> keys;
  std::vector<std::uint32_t> numbers;  // of the tets
};

Joined join(std::vector<Bytes> messages) {
  Joined joined;
  TetPackets packets(std::move(messages));
  for (TetPacket& packet : packets.all()) {
    packet.take_links();
    for (const std::uint32_t number : packet.rest.get_view<std::uint32_t>()) joined.numbers.push_back(number);
  }
  const TaskRunner runner(2);
  packets.number_verts(runner, [&](std::uint64_t key, std::uint32_t p, std::uint32_t i, bool is_new) {
    REQUIRE(packets.all()[p].verts.keys[i] == key);
    if (!is_new) return;
    joined.keys.push_back(key);
    joined.mesh.points.push_back(packets.all()[p].verts.points[i]);
  });
  packets.move_linked_tets_into(joined.mesh, runner, [&](const TetPacket& packet, FaceCode link) {
    if ((link.tet() & kByNumber) == 0) return link.of_tet(packet.first_tet + link.tet());
    const auto at = std::ranges::find(joined.numbers, link.tet() & ~kByNumber);
    return at == joined.numbers.end() ? FaceCode()
                                      : link.of_tet(static_cast<std::uint32_t>(at - joined.numbers.begin()));
  });
  joined.mesh.to_fixed.resize(joined.mesh.to_region.size(), 0);
  return joined;
}

}  // namespace

TEST_CASE("Tets that several parts send are one linked mesh where they arrive") {
  const TetMesh octahedron = tet_tests::make_octahedron({0, 0, 0});
  REQUIRE(find_fault(octahedron) == std::string());
  TetPacker packer(octahedron);
  const Joined joined = join(
      {pack(octahedron, packer, {4, 1, 7}), pack(octahedron, packer, {0, 2, 5}), pack(octahedron, packer, {3, 6})});
  CHECK(find_fault(joined.mesh) == std::string());
  CHECK(joined.numbers == std::vector<std::uint32_t>{4, 1, 7, 0, 2, 5, 3, 6});
  CHECK(std::ranges::is_sorted(joined.keys));
  REQUIRE(joined.keys.size() == octahedron.points.size());
  for (std::size_t i = 0; i < joined.numbers.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k) {
      const std::uint32_t vert = octahedron.to_vert[joined.numbers[i] * 4 + k];
      CHECK(joined.keys[joined.mesh.to_vert[i * 4 + k]] == key_of(vert));
      CHECK(joined.mesh.points[joined.mesh.to_vert[i * 4 + k]] == octahedron.points[vert]);
    }
  }
  for (const FaceCode face : joined.mesh.faces()) {
    const FaceCode behind = joined.mesh.behind(face),
                   before = octahedron.behind({joined.numbers[face.tet()], face.side()});
    REQUIRE(behind.valid() == before.valid());
    if (behind.valid()) CHECK(FaceCode(joined.numbers[behind.tet()], behind.side()) == before);
  }
}

TEST_CASE("Faces whose tets nobody sends are open where the others arrive") {
  const TetMesh octahedron = tet_tests::make_octahedron({0, 0, 0});
  TetPacker packer(octahedron);
  const Joined joined = join({pack(octahedron, packer, {0, 1}), pack(octahedron, packer, {})});
  CHECK(find_fault(joined.mesh) == std::string());
  CHECK(joined.mesh.points.size() == 5);
  int linked = 0;
  for (const FaceCode face : joined.mesh.faces()) linked += joined.mesh.behind(face).valid();
  CHECK(linked == 2);
}

TEST_CASE("A message that is cut short is refused") {
  const TetMesh octahedron = tet_tests::make_octahedron({0, 0, 0});
  TetPacker packer(octahedron);
  Bytes bytes = pack(octahedron, packer, {0, 1, 2});
  bytes.resize(bytes.size() / 2);
  CHECK_THROWS_AS(TetPacket(bytes), Error);
}

// Entities and places in 32 bits.
#include <catch2/catch.hpp>
#include <set>
#include <vector>

#include "tetloom/part_mesh.hpp"

using namespace tetloom;

TEST_CASE("a packed entity comes back at its limits") {
  CHECK_FALSE(PackedEntity().unpack().valid());
  CHECK(PackedEntity(ModelEntity{}) == PackedEntity());
  for (int dim = 0; dim < 4; ++dim)
    for (const std::uint32_t index : {0u, 1u, PackedEntity::kMaxIndex - 1, PackedEntity::kMaxIndex}) {
      const ModelEntity entity(dim, index);
      CHECK(PackedEntity(entity).unpack() == entity);
      CHECK(PackedEntity(entity) != PackedEntity());
    }
}

TEST_CASE("packed entities ascend as entities do, and none comes last") {
  std::vector<ModelEntity> entities;
  for (int dim = 0; dim < 4; ++dim)
    for (const std::uint32_t index : {0u, 7u, PackedEntity::kMaxIndex}) entities.push_back(ModelEntity(dim, index));
  for (std::size_t i = 0; i + 1 < entities.size(); ++i)
    CHECK(PackedEntity(entities[i]) < PackedEntity(entities[i + 1]));
  CHECK(PackedEntity(entities.back()) < PackedEntity());
}

TEST_CASE("a place in a cell comes back at its limits, and no two share a code") {
  std::set<CellPlace> codes{CellPlace()};
  std::size_t count = 1;
  for (const CellKind kind : kAllCellKinds) {
    const std::uint32_t cells = kind == CellKind::Tet ? CellPlace::kMaxTets : CellPlace::kMaxOthers;
    const std::uint32_t places = kind == CellKind::Tet ? 4 : 8;
    for (const std::uint32_t cell : {0u, 1u, cells / 2, cells - 2, cells - 1})
      for (std::uint32_t place = 0; place < places; ++place, ++count) {
        const CellPlace code(kind, cell, place);
        CHECK(code.valid());
        CHECK(code.kind() == kind);
        CHECK(code.cell() == cell);
        CHECK(code.place() == place);
        codes.insert(code);
      }
  }
  CHECK(codes.size() == count);
  CHECK_FALSE(CellPlace().valid());
}

TEST_CASE("places ascend by kind, then cell, then place") {
  CHECK(CellPlace(CellKind::Tet, 5, 3) < CellPlace(CellKind::Tet, 6, 0));
  CHECK(CellPlace(CellKind::Tet, CellPlace::kMaxTets - 1, 3) < CellPlace(CellKind::Pyramid, 0, 0));
  CHECK(CellPlace(CellKind::Pyramid, CellPlace::kMaxOthers - 1, 7) < CellPlace(CellKind::Prism, 0, 0));
  CHECK(CellPlace(CellKind::Prism, 9, 7) < CellPlace(CellKind::Hex, 0, 0));
  CHECK(CellPlace(CellKind::Hex, CellPlace::kMaxOthers - 1, 7) < CellPlace());
}

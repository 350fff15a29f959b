#pragma once
// Distinct 32-bit id types, the index of nothing, and the name of a model entity.
#include <array>
#include <compare>
#include <cstdint>
#include <string_view>

namespace tetloom {

/// The index of nothing, in arrays of raw indices of any kind.
inline constexpr std::uint32_t kNone = 0xffffffffu;

/// A 0-based index that cannot be mistaken for the index of another kind. In files, reports and messages a model
/// entity is shown by its *tag*, which is its index + 1.
template <class Kind>
struct Id {
  static constexpr std::uint32_t kNone = tetloom::kNone;
  std::uint32_t value = kNone;

  constexpr Id() = default;
  constexpr explicit Id(std::size_t index) : value(static_cast<std::uint32_t>(index)) {}
  constexpr bool valid() const { return value != kNone; }
  constexpr std::uint32_t tag() const { return value + 1; }
  friend constexpr auto operator<=>(Id, Id) = default;
};

using ModelVertexId = Id<struct ModelVertexKind>;
using ModelEdgeId = Id<struct ModelEdgeKind>;
using ModelFaceId = Id<struct ModelFaceKind>;
using ModelRegionId = Id<struct ModelRegionKind>;

/// What entities are called, by dimension.
inline constexpr std::array<std::string_view, 4> kEntityKinds{"vertex", "edge", "face", "region"};

/// A model entity of any dimension: 0 vertex, 1 edge, 2 face, 3 region. The default is "no entity" (dim 4).
struct ModelEntity {
  std::uint8_t dim = 4;
  std::uint32_t index = kNone;

  constexpr ModelEntity() = default;
  constexpr ModelEntity(int dimension, std::uint32_t i) : dim(static_cast<std::uint8_t>(dimension)), index(i) {}
  constexpr ModelEntity(ModelVertexId id) : ModelEntity(0, id.value) {}
  constexpr ModelEntity(ModelEdgeId id) : ModelEntity(1, id.value) {}
  constexpr ModelEntity(ModelFaceId id) : ModelEntity(2, id.value) {}
  constexpr ModelEntity(ModelRegionId id) : ModelEntity(3, id.value) {}
  constexpr bool valid() const { return dim <= 3 && index != kNone; }
  constexpr std::uint32_t tag() const { return index + 1; }
  friend constexpr auto operator<=>(const ModelEntity&, const ModelEntity&) = default;
};

}  // namespace tetloom

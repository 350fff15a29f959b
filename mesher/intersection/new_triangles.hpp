#pragma once
// Which triangles of a surface were not in the one before.
#include <cstdint>
#include <vector>

#include "tetloom/mesh_data.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// The triangles of a surface mesh by face and coordinates, to find them again in the next mesh of the model.
class KnownTriangles {
 public:
  KnownTriangles() = default;
  /// O(n log n).
  KnownTriangles(const Mesh& surface, const TaskRunner& runner);

  /// Per triangle of `surface`, 1 unless a triangle of the same face had the same corners, to the bit and in the same
  /// order up to a rotation; empty where nothing is known. O(n log n).
  std::vector<std::uint8_t> find_new(const Mesh& surface, const TaskRunner& runner) const;

 private:
  /// Nine coordinates, from the smallest corner on, and the face.
  struct Key {
    std::array<double, 9> coordinates{};
    std::uint32_t face = 0;
    auto operator<=>(const Key&) const = default;
  };
  static Key key_of(const Mesh& surface, std::size_t triangle);

  std::vector<Key> keys_;  // ascending
};

}  // namespace tetloom

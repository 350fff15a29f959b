#pragma once
// Private to core/io: meshes of second order in files.
#include <algorithm>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "core/io/element_nodes_detail.hpp"

namespace tetloom::detail {

/// The mid nodes of elements as a file lists them, until it has been read.
class MidNodeReader {
 public:
  /// Notes the mid nodes of the edges of an element, both by their numbers among all points of the file.
  template <class Element>
  void add(const Element& verts, std::span<const LocalEdge> edges, std::span<const std::uint32_t> mids) {
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const auto [low, high] = std::minmax(verts[edges[e][0]], verts[edges[e][1]]);
      found_.push_back({low, high, mids[e]});
    }
  }

  /// Puts mid nodes behind the vertices, with their entities and the values of fields, and fills in `mid_to_vert`;
  /// changes nothing where no mid node was found. Where `classify`, mid nodes get the entities of elements. Pre: the
  /// vertices of elements are points of the mesh. Throws Error(InputUnreadable) for mid nodes that are not there, of
  /// several edges, or vertices as well, Error(InputUnsuitable) for several on one edge and elements of both orders.
  void finish(const InputFile& file, Mesh& mesh, bool classify);

 private:
  struct Found {
    std::uint32_t low, high, mid;
    friend auto operator<=>(const Found&, const Found&) = default;
  };
  void check(const InputFile& file, const Mesh& mesh) const;

  std::vector<Found> found_;
};

}  // namespace tetloom::detail

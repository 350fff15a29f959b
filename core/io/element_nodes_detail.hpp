#pragma once
// Private to core/io: the nodes of elements as files list them, vertices first, then mid nodes.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/io/formats_detail.hpp"
#include "core/mesh/mid_nodes.hpp"

namespace tetloom::detail {

inline constexpr std::size_t kMostNodes = 20;  // of a hexahedron of second order

/// The edges of the elements of a block, in the order of kCellShapes, which is also that of VTK, Abaqus and MED.
constexpr std::span<const LocalEdge> edges_of(Block block) {
  switch (block) {
    case Block::Edge: return kLineEdges;
    case Block::Triangle: return kTriangleEdges;
    case Block::Quad: return kQuadEdges;
    case Block::Tet: return shape_of(CellKind::Tet).edges();
    case Block::Pyramid: return shape_of(CellKind::Pyramid).edges();
    case Block::Prism: return shape_of(CellKind::Prism).edges();
    case Block::Hex: return shape_of(CellKind::Hex).edges();
  }
  return {};
}

inline constexpr std::array<LocalEdge, 9> kPrismEdgesUpFirst{
    {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 4}, {2, 5}, {3, 4}, {4, 5}, {5, 3}}};
inline constexpr std::array<LocalEdge, 12> kHexEdgesUpFirst{
    {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 5}, {2, 6}, {3, 7}, {4, 5}, {5, 6}, {6, 7}, {7, 4}}};

/// The same in the order of Nastran, CGNS and Exodus: edges of the base, those up from it, those of the top.
constexpr std::span<const LocalEdge> edges_up_first(Block block) {
  if (block == Block::Prism) return kPrismEdgesUpFirst;
  if (block == Block::Hex) return kHexEdgesUpFirst;
  return edges_of(block);
}

constexpr std::size_t vertices_of(Block block) {
  constexpr std::array<std::size_t, kBlocks> counts{2, 3, 4, 4, 5, 6, 8};
  return counts[static_cast<std::size_t>(block)];
}

/// The nodes of one element.
class NodeList {
 public:
  std::size_t size() const { return count_; }
  std::uint32_t operator[](std::size_t i) const { return nodes_[i]; }
  const std::uint32_t* begin() const { return nodes_.data(); }
  const std::uint32_t* end() const { return nodes_.data() + count_; }
  void add(std::uint32_t node) { nodes_[count_++] = node; }

 private:
  std::array<std::uint32_t, kMostNodes> nodes_;
  std::size_t count_ = 0;
};

/// The nodes of elements of first or second order.
class ElementNodes {
 public:
  /// `mesh` outlives the object.
  explicit ElementNodes(const Mesh& mesh) : mids_(mesh) {}

  bool are_second_order() const { return !mids_.empty(); }
  /// How many nodes each element of a block has.
  std::size_t count(Block block) const {
    return vertices_of(block) + (are_second_order() ? edges_of(block).size() : 0);
  }
  /// The mid node between two vertices of an element. Pre: are_second_order().
  std::uint32_t mid(std::uint32_t a, std::uint32_t b) const { return mids_.point(a, b); }
  /// Of an element with the vertices `verts`, which may be turned: mid nodes in the order of `edges`.
  template <class Element>
  NodeList of(const Element& verts, std::span<const LocalEdge> edges) const {
    NodeList nodes;
    for (const std::uint32_t v : verts) nodes.add(v);
    if (are_second_order())
      for (const auto& [a, b] : edges) nodes.add(mids_.point(verts[a], verts[b]));
    return nodes;
  }
  template <class Element>
  NodeList of(const Element& verts, Block block) const {
    return of(verts, edges_of(block));
  }

 private:
  MidNodes mids_;
};

}  // namespace tetloom::detail

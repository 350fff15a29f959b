#pragma once
// Private to core/mesh: how the parts of validate_mesh gather what they find.
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/cell_shape.hpp"
#include "core/mesh/validate.hpp"

namespace tetloom::detail {

/// Collects problems, one entry per kind of problem and kind of element, in the order of their first appearance.
class ProblemLog {
 public:
  explicit ProblemLog(const Mesh& mesh) : mesh_(mesh) {}
  void add(ProblemKind kind, ElementKind element, std::uint64_t index);
  /// For arrays as a whole.
  void add_array(const std::string& message);
  std::vector<MeshProblem> take();

 private:
  std::optional<Vec3> point_on(ElementKind element, std::uint64_t index) const;
  const Mesh& mesh_;
  std::vector<MeshProblem> problems_;
};

/// Which points the elements use.
struct PointMarks {
  std::vector<bool> used, on_surface, on_edge;
};

constexpr ElementKind element_kind(CellKind kind) {
  constexpr std::array<ElementKind, 4> kinds{ElementKind::Tet, ElementKind::Pyramid, ElementKind::Prism,
                                             ElementKind::Hex};
  return kinds[static_cast<std::size_t>(kind)];
}

/// Faces of cells against each other and against the surface elements: pairing, sides, interfaces, watertightness.
void validate_faces(const Mesh& mesh, ProblemLog& log, ValidationReport& report);
/// Edges of the surface elements: open and non-manifold ones, orientation, mesh edges where faces meet.
void validate_surface_edges(const Mesh& mesh, const PointMarks& marks, ProblemLog& log, ValidationReport& report);
/// Points, edges, surface elements and cells against the entities that they are classified on.
void validate_classification(const Mesh& mesh, const PointMarks& marks, ProblemLog& log);

/// A directed edge filed under its ends in ascending order.
struct EdgeUse {
  std::uint32_t low = 0, high = 0;
  std::uint64_t code = 0;  ///< element * 4 + is_mesh_edge * 2 + runs from high to low

  std::size_t element() const { return static_cast<std::size_t>(code >> 2); }
  bool is_mesh_edge() const { return (code & 2) != 0; }
  bool reversed() const { return (code & 1) != 0; }
  friend auto operator<=>(const EdgeUse&, const EdgeUse&) = default;
};
inline EdgeUse make_edge_use(std::uint32_t from, std::uint32_t to, std::uint64_t element, bool is_mesh_edge = false) {
  const std::uint64_t code = element * 4 + (is_mesh_edge ? 2 : 0);
  return from < to ? EdgeUse{from, to, code} : EdgeUse{to, from, code | 1};
}

/// Sorts `uses` and calls visit(group) for every pair of points.
template <class Visit>
void for_each_edge_group(std::vector<EdgeUse>& uses, const Visit& visit) {
  std::sort(uses.begin(), uses.end());
  for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
    while (end < uses.size() && uses[end].low == uses[begin].low && uses[end].high == uses[begin].high) ++end;
    visit(std::span<const EdgeUse>(uses).subspan(begin, end - begin));
  }
}

}  // namespace tetloom::detail

#pragma once
// Private to core/mesh: how the parts of validate_mesh gather what they find.
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/filing.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom::detail {

/// Collects problems, one entry per kind of problem and kind of element, in the order of their first appearance.
class ProblemLog {
 public:
  explicit ProblemLog(const Mesh& mesh) : mesh_(mesh) {}
  void add(ProblemKind kind, ElementKind element, std::uint64_t index);
  /// For arrays as a whole.
  void add_array(const std::string& message);
  /// Adds what another log of the same mesh has, as if it had been added here after the rest.
  void append(ProblemLog&& later);
  bool empty() const { return problems_.empty(); }
  std::vector<MeshProblem> take();

 private:
  std::optional<Vec3> point_on(ElementKind element, std::uint64_t index) const;
  const Mesh& mesh_;
  std::vector<MeshProblem> problems_;
};

/// Calls body(begin, end, log) for blocks of [0, count), with a log for each, and adds all to `log` in their order.
template <class Body>
void log_blocks(const Mesh& mesh, std::size_t count, const BlockLoop& loop, ProblemLog& log, const Body& body) {
  for (ProblemLog& of_block : map_blocks(loop, count, std::size_t{1} << 15, ProblemLog(mesh), body))
    log.append(std::move(of_block));
}

/// One bit per point.
class PointSet {
 public:
  static constexpr std::size_t kPointsPerWord = 64;

  explicit PointSet(std::size_t points) : words_((points + kPointsPerWord - 1) / kPointsPerWord, 0) {}
  bool operator[](std::size_t i) const { return (words_[i / kPointsPerWord] >> (i % kPointsPerWord) & 1) != 0; }
  void insert(std::size_t i) { words_[i / kPointsPerWord] |= std::uint64_t{1} << (i % kPointsPerWord); }
  std::span<std::uint64_t> words() { return words_; }

 private:
  std::vector<std::uint64_t> words_;
};

/// Which points the elements use.
struct PointMarks {
  PointSet used, on_surface, on_edge;
};

constexpr ElementKind element_kind(CellKind kind) {
  constexpr std::array<ElementKind, 4> kinds{ElementKind::Tet, ElementKind::Pyramid, ElementKind::Prism,
                                             ElementKind::Hex};
  return kinds[static_cast<std::size_t>(kind)];
}

/// Faces of cells against each other and against the surface elements: pairing, sides, interfaces, watertightness.
void validate_faces(const Mesh& mesh, const BlockLoop& loop, ProblemLog& log, ValidationReport& report);
/// Edges of the surface elements: open and non-manifold ones, orientation, mesh edges where faces meet.
void validate_surface_edges(const Mesh& mesh, const PointMarks& marks, const BlockLoop& loop, ProblemLog& log,
                            ValidationReport& report);
/// Points, edges, surface elements and cells against the entities that they are classified on.
void validate_classification(const Mesh& mesh, const PointMarks& marks, const BlockLoop& loop, ProblemLog& log);

/// A directed edge filed under its ends in ascending order.
struct ElementEdge {
  std::uint32_t low = 0, high = 0;
  std::uint64_t code = 0;  ///< element * 4 + is_mesh_edge * 2 + runs from high to low

  std::size_t element() const { return static_cast<std::size_t>(code >> 2); }
  bool is_mesh_edge() const { return (code & 2) != 0; }
  bool reversed() const { return (code & 1) != 0; }
  friend auto operator<=>(const ElementEdge&, const ElementEdge&) = default;
};
inline ElementEdge make_edge_use(std::uint32_t from, std::uint32_t to, std::uint64_t element,
                                 bool is_mesh_edge = false) {
  const std::uint64_t code = element * 4 + (is_mesh_edge ? 2 : 0);
  return from < to ? ElementEdge{from, to, code} : ElementEdge{to, from, code | 1};
}

/// What is found at the edges around a range of points.
struct EdgeFindings {
  ProblemLog log;
  std::size_t open = 0, nonmanifold = 0;
};

/// Calls emit(begin, end, add) for blocks of the sources [0, count), which calls add(use) for the uses of edges in
/// them; then visit(group, findings) for all uses of each pair of points, ascending. All findings go to `log` and
/// `report`, in the order of the pairs.
template <class Emit, class Visit>
void check_edge_groups(const Mesh& mesh, std::size_t count, const BlockLoop& loop, const Emit& emit, const Visit& visit,
                       ProblemLog& log, ValidationReport& report) {
  const KeyRanges ranges(mesh.points.size());
  std::vector<EdgeFindings> findings(ranges.count(), EdgeFindings{ProblemLog(mesh)});
  const auto file_uses = [&](std::size_t begin, std::size_t end, const auto& file) {
    emit(begin, end, [&](const ElementEdge& use) { file(ranges.of(use.low), use); });
  };
  const auto visit_range = [&](std::size_t range, std::span<ElementEdge> uses) {
    std::sort(uses.begin(), uses.end());
    for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
      while (end < uses.size() && uses[end].low == uses[begin].low && uses[end].high == uses[begin].high) ++end;
      visit(std::span<const ElementEdge>(uses.subspan(begin, end - begin)), findings[range]);
    }
  };
  for_each_filed_range<ElementEdge>(count, ranges, loop, file_uses, visit_range);
  for (EdgeFindings& found : findings) {
    log.append(std::move(found.log));
    report.open_edges += found.open;
    report.nonmanifold_edges += found.nonmanifold;
  }
}

}  // namespace tetloom::detail

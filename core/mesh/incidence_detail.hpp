#pragma once
// Private to core: finding shared edges and faces by grouping them under their lowest vertex, in windows of vertices
// that bound the working memory whatever the size of the mesh.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/mesh_access.hpp"

namespace tetloom::detail {

/// Local vertices of the edges of a tet; pairs k and 5 - k lie opposite to each other.
inline constexpr std::array<std::array<int, 2>, 6> kTetEdge{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// Consecutive ranges [first, last) of keys whose counts add up to at most `limit`, or which hold a single key.
struct Window {
  std::uint32_t first = 0, last = 0;
  std::size_t uses = 0;
};
std::vector<Window> cut_windows(std::span<const std::uint32_t> counts, std::size_t limit);

/// Scatters uses into one bucket per key of a window, in the order in which they are added.
template <class Use>
class WindowBuckets {
 public:
  WindowBuckets(const Window& window, std::span<const std::uint32_t> counts, std::vector<Use>& storage)
      : first_(window.first), storage_(storage), ends_(window.last - window.first + 1, 0) {
    for (std::uint32_t key = window.first; key < window.last; ++key)
      ends_[key - first_ + 1] = ends_[key - first_] + counts[key];
    if (storage_.size() < window.uses) storage_.resize(window.uses);
    next_.assign(ends_.begin(), ends_.end() - 1);
  }
  bool covers(std::uint32_t key) const { return key - first_ < next_.size(); }  // wraps below first_
  void add(std::uint32_t key, const Use& use) { storage_[next_[key - first_]++] = use; }
  std::span<Use> bucket(std::uint32_t key) {
    return {storage_.data() + ends_[key - first_], storage_.data() + ends_[key - first_ + 1]};
  }

 private:
  std::uint32_t first_;
  std::vector<Use>& storage_;
  std::vector<std::size_t> ends_;  // of the bucket before each key
  std::vector<std::size_t> next_;
};

/// Calls visit(a, b), a < b, once for every pair of different points that an element of `elements` joins. The order
/// depends on the elements alone. `Elements` are arrays of 3 or 4 point indices below `point_count`.
template <class Element, class Visit>
void for_each_unique_edge(std::span<const Element> elements, std::size_t point_count, const Visit& visit) {
  constexpr std::size_t kLimit = std::size_t{1} << 25;  // 128 MiB of uses
  const auto for_each_pair = [&](const auto& body) {
    for (const Element& element : elements)
      for (std::size_t i = 0; i + 1 < element.size(); ++i)
        for (std::size_t j = i + 1; j < element.size(); ++j)
          body(std::min(element[i], element[j]), std::max(element[i], element[j]));
  };
  std::vector<std::uint32_t> counts(point_count, 0);
  for_each_pair([&](std::uint32_t low, std::uint32_t) { ++counts[low]; });
  std::vector<std::uint32_t> last_seen_by(point_count, 0xffffffffu);
  std::vector<std::uint32_t> storage;
  for (const Window& window : cut_windows(counts, kLimit)) {
    WindowBuckets<std::uint32_t> buckets(window, counts, storage);
    for_each_pair([&](std::uint32_t low, std::uint32_t high) {
      if (buckets.covers(low)) buckets.add(low, high);
    });
    for (std::uint32_t low = window.first; low < window.last; ++low) {
      for (const std::uint32_t high : buckets.bucket(low)) {
        if (last_seen_by[high] == low || high == low) continue;
        last_seen_by[high] = low;
        visit(low, high);
      }
    }
  }
}

/// What a face belongs to: a cell of one of the four kinds, or a surface element.
enum class FaceOwner : std::uint8_t { Tet, Pyramid, Prism, Hex, Triangle, Quad };

/// A face of a cell, a triangle or a quadrilateral, filed under its lowest vertex.
struct FaceUse {
  std::uint32_t mid = 0, high = 0;  ///< the vertices beside the lowest one, mid <= high
  std::uint64_t code = 0;           ///< element * 256 + is_quad * 128 + owner * 16 + flipped * 8 + local face

  std::size_t element() const { return static_cast<std::size_t>(code >> 8); }
  bool is_quad() const { return (code & 128) != 0; }
  FaceOwner owner() const { return static_cast<FaceOwner>((code >> 4) & 7); }
  bool is_surface() const { return owner() >= FaceOwner::Triangle; }
  /// Of a face of a cell.
  CellRef cell() const { return {static_cast<CellKind>(owner()), element()}; }
  /// Whether the owner runs from the lowest vertex to `high` first (outward orientation for a cell).
  bool flipped() const { return (code & 8) != 0; }
  int local_face() const { return static_cast<int>(code & 7); }
  bool meets_same(const FaceUse& b) const { return mid == b.mid && high == b.high && is_quad() == b.is_quad(); }
  friend bool operator<(const FaceUse& a, const FaceUse& b) {
    if (a.mid != b.mid) return a.mid < b.mid;
    if (a.high != b.high) return a.high < b.high;
    if (a.is_quad() != b.is_quad()) return b.is_quad();
    return a.code < b.code;
  }
};

/// The vertices of a face, in a cycle.
struct FacePoints {
  std::size_t size = 0;  ///< 3 or 4
  std::array<std::uint32_t, 4> cycle{};
};
FacePoints points_of(const Mesh& mesh, const FaceUse& use);

/// The lowest vertex of a face, its two neighbours, and whether the higher one comes first.
struct SortedFace {
  std::uint32_t low, mid, high;
  bool flipped;
};
inline SortedFace sorted_face(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  bool flipped = false;
  if (a > b) std::swap(a, b), flipped = !flipped;
  if (b > c) std::swap(b, c), flipped = !flipped;
  if (a > b) std::swap(a, b), flipped = !flipped;
  return {a, b, c, flipped};
}
inline SortedFace sorted_face(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  const std::array<std::uint32_t, 4> v{a, b, c, d};
  const auto at = static_cast<std::size_t>(std::min_element(v.begin(), v.end()) - v.begin());
  const std::uint32_t next = v[(at + 1) % 4], before = v[(at + 3) % 4];
  return {v[at], std::min(next, before), std::max(next, before), next > before};
}

/// Calls body(sorted face, code) for all faces of cells of one kind.
template <CellKind Kind, class Cell, class Body>
void for_each_cell_face(const std::vector<Cell>& cells, const Body& body) {
  constexpr const CellShape& shape = shape_of(Kind);
  constexpr std::uint64_t owner = static_cast<std::uint64_t>(Kind) * 16;
  for (std::uint64_t c = 0; c < cells.size(); ++c) {
    const Cell& v = cells[c];
    for (std::uint64_t f = 0; f < shape.face_count; ++f) {
      const auto& at = shape.face[f].vert;
      if (shape.face[f].count == 3)
        body(sorted_face(v[at[0]], v[at[1]], v[at[2]]), c * 256 + owner + f);
      else
        body(sorted_face(v[at[0]], v[at[1]], v[at[2]], v[at[3]]), c * 256 + 128 + owner + f);
    }
  }
}

/// Calls body(sorted face, code) for all faces of cells, triangles and quadrilaterals.
template <class Body>
void for_each_face_use(const Mesh& mesh, const Body& body) {
  for_each_cell_face<CellKind::Tet>(mesh.tet_to_vert, body);
  for_each_cell_face<CellKind::Pyramid>(mesh.pyramid_to_vert, body);
  for_each_cell_face<CellKind::Prism>(mesh.prism_to_vert, body);
  for_each_cell_face<CellKind::Hex>(mesh.hex_to_vert, body);
  constexpr std::uint64_t triangle = static_cast<std::uint64_t>(FaceOwner::Triangle) * 16;
  constexpr std::uint64_t quad = static_cast<std::uint64_t>(FaceOwner::Quad) * 16 + 128;
  for (std::uint64_t t = 0; t < mesh.tri_to_vert.size(); ++t) {
    const auto& v = mesh.tri_to_vert[t];
    body(sorted_face(v[0], v[1], v[2]), t * 256 + triangle);
  }
  for (std::uint64_t q = 0; q < mesh.quad_to_vert.size(); ++q) {
    const auto& v = mesh.quad_to_vert[q];
    body(sorted_face(v[0], v[1], v[2], v[3]), q * 256 + quad);
  }
}

/// Sorts `uses`, which agree in three vertices, by the fourth and calls visit(low, uses) for each of those.
template <class Visit>
void visit_by_fourth_vertex(const Mesh& mesh, std::uint32_t low, std::span<FaceUse> uses, const Visit& visit) {
  const auto fourth = [&](const FaceUse& use) {
    const FacePoints face = points_of(mesh, use);
    const auto at = std::find(face.cycle.begin(), face.cycle.end(), low) - face.cycle.begin();
    return face.cycle[static_cast<std::size_t>(at + 2) % 4];
  };
  const auto differs = [&](const FaceUse& a, const FaceUse& b) { return fourth(a) != fourth(b); };
  if (std::adjacent_find(uses.begin(), uses.end(), differs) == uses.end())
    return visit(low, std::span<const FaceUse>(uses));
  std::stable_sort(uses.begin(), uses.end(), [&](const FaceUse& a, const FaceUse& b) { return fourth(a) < fourth(b); });
  for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
    while (end < uses.size() && !differs(uses[begin], uses[end])) ++end;
    visit(low, std::span<const FaceUse>(uses.subspan(begin, end - begin)));
  }
}

/// Calls visit(low, uses) for every cycle of three or four points that is a face of a cell or a surface element; `uses`
/// are ascending.
template <class Visit>
void for_each_face_group(const Mesh& mesh, const Visit& visit) {
  constexpr std::size_t kLimit = std::size_t{1} << 23;  // 128 MiB of uses
  std::vector<std::uint32_t> counts(mesh.points.size(), 0);
  for_each_face_use(mesh, [&](const SortedFace& face, std::uint64_t) { ++counts[face.low]; });
  std::vector<FaceUse> storage;
  for (const Window& window : cut_windows(counts, kLimit)) {
    WindowBuckets<FaceUse> buckets(window, counts, storage);
    for_each_face_use(mesh, [&](const SortedFace& face, std::uint64_t code) {
      if (buckets.covers(face.low)) buckets.add(face.low, {face.mid, face.high, code | (face.flipped ? 8u : 0u)});
    });
    for (std::uint32_t low = window.first; low < window.last; ++low) {
      const std::span<FaceUse> bucket = buckets.bucket(low);
      std::sort(bucket.begin(), bucket.end());
      for (std::size_t begin = 0, end = 0; begin < bucket.size(); begin = end) {
        while (end < bucket.size() && bucket[end].meets_same(bucket[begin])) ++end;
        const std::span<FaceUse> uses = bucket.subspan(begin, end - begin);
        if (uses[0].is_quad() && uses.size() > 1)
          visit_by_fourth_vertex(mesh, low, uses, visit);
        else
          visit(low, std::span<const FaceUse>(uses));
      }
    }
  }
}

}  // namespace tetloom::detail

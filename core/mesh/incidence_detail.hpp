#pragma once
// Private to core: finding shared edges and faces by grouping them under their lowest vertex, one range of vertices
// beside the other.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

#include "core/base/filing.hpp"
#include "core/mesh/mesh_access.hpp"

namespace tetloom::detail {

/// Scatters uses into one bucket per key of [first, last), in the order in which they are added: all of them are to be
/// counted first, then added.
template <class Use>
class KeyBuckets {
 public:
  KeyBuckets(std::size_t first, std::size_t last) : first_(first), places_(last - first + 1, 0) {}

  bool covers(std::uint32_t key) const { return key - first_ < places_.size() - 1; }  // wraps below first_
  void count(std::uint32_t key) { ++places_[key - first_ + 1]; }
  void end_counting() {
    std::partial_sum(places_.begin(), places_.end(), places_.begin());
    uses_ = std::make_unique_for_overwrite<Use[]>(places_.back());
  }
  void add(std::uint32_t key, const Use& use) { uses_[places_[key - first_]++] = use; }
  /// Calls visit(key, bucket) in the order of the keys, when all has been added.
  template <class Visit>
  void for_each(const Visit& visit) {
    std::size_t begin = 0;
    for (std::size_t i = 0; i + 1 < places_.size(); begin = places_[i++])
      visit(static_cast<std::uint32_t>(first_ + i), std::span<Use>(uses_.get() + begin, uses_.get() + places_[i]));
  }

 private:
  std::size_t first_;
  std::vector<std::size_t> places_;  // of the bucket before each key, and at last where each bucket ends
  std::unique_ptr<Use[]> uses_;
};

/// Moves the different numbers to the front, in an order that depends on the sequence alone, and returns how many
/// there are.
inline std::size_t keep_different(std::span<std::uint32_t> numbers) {
  constexpr std::size_t kFew = 128;
  if (numbers.size() > kFew) {
    std::sort(numbers.begin(), numbers.end());
    return static_cast<std::size_t>(std::unique(numbers.begin(), numbers.end()) - numbers.begin());
  }
  std::size_t kept = 0;
  for (const std::uint32_t number : numbers) {
    const auto end = numbers.begin() + static_cast<std::ptrdiff_t>(kept);
    if (std::find(numbers.begin(), end, number) == end) numbers[kept++] = number;
  }
  return kept;
}

/// Calls file(range, element) once for every range that holds a vertex of the element which is not its greatest.
template <class Element, class File>
void file_by_lower_vertices(const Element& v, std::size_t element, const KeyRanges& ranges, const File& file) {
  const std::uint32_t greatest = *std::max_element(v.begin(), v.end());
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (v[i] == greatest) continue;
    const std::size_t range = ranges.of(v[i]);
    bool known = false;
    for (std::size_t j = 0; j < i; ++j) known |= v[j] != greatest && ranges.of(v[j]) == range;
    if (!known) file(range, element);
  }
}

/// Calls visit(a, b, result), a < b, once for every pair of different points that an element of `elements` joins, and
/// returns the results, one for each of some ranges of points, in their order. Ranges, and the order in each, depend on
/// the elements alone. `Elements` are arrays of 3 or 4 point indices below `point_count`.
template <class Result, class Element, class Visit>
std::vector<Result> map_unique_edges(const std::vector<Element>& elements, std::size_t point_count,
                                     const BlockLoop& loop, const Visit& visit) {
  const KeyRanges ranges(point_count);
  std::vector<Result> results(ranges.count());
  const auto emit = [&](std::size_t begin, std::size_t end, const auto& file) {
    for (std::size_t e = begin; e < end; ++e) file_by_lower_vertices(elements[e], e, ranges, file);
  };
  const auto visit_range = [&](std::size_t range, std::span<const std::uint64_t> filed) {
    KeyBuckets<std::uint32_t> buckets(ranges.first(range), ranges.last(range));
    const auto for_each_pair = [&](const auto& body) {
      for (const std::uint64_t e : filed)
        for (std::size_t i = 0; i + 1 < elements[e].size(); ++i)
          for (std::size_t j = i + 1; j < elements[e].size(); ++j) {
            const auto [low, high] = std::minmax(elements[e][i], elements[e][j]);
            if (low != high && buckets.covers(low)) body(low, high);
          }
    };
    for_each_pair([&](std::uint32_t low, std::uint32_t) { buckets.count(low); });
    buckets.end_counting();
    for_each_pair([&](std::uint32_t low, std::uint32_t high) { buckets.add(low, high); });
    Result result;
    buckets.for_each([&](std::uint32_t low, std::span<std::uint32_t> highs) {
      for (const std::uint32_t high : highs.first(keep_different(highs))) visit(low, high, result);
    });
    results[range] = std::move(result);
  };
  for_each_filed_range<std::uint64_t>(elements.size(), ranges, loop, emit, visit_range);
  return results;
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

/// Calls body(sorted face, code) for all faces of a cell.
template <CellKind Kind, class Cell, class Body>
void for_each_cell_face(const Cell& v, std::uint64_t element, const Body& body) {
  constexpr const CellShape& shape = shape_of(Kind);
  constexpr std::uint64_t owner = static_cast<std::uint64_t>(Kind) * 16;
  for (std::uint64_t f = 0; f < shape.face_count; ++f) {
    const auto& at = shape.face[f].vert;
    if (shape.face[f].count == 3)
      body(sorted_face(v[at[0]], v[at[1]], v[at[2]]), element * 256 + owner + f);
    else
      body(sorted_face(v[at[0]], v[at[1]], v[at[2]], v[at[3]]), element * 256 + 128 + owner + f);
  }
}

/// Calls body(sorted face, code) for all faces of a cell, or for a surface element.
template <class Body>
void for_each_face_of(const Mesh& mesh, FaceOwner owner, std::uint64_t element, const Body& body) {
  constexpr std::uint64_t triangle = static_cast<std::uint64_t>(FaceOwner::Triangle) * 16;
  constexpr std::uint64_t quad = static_cast<std::uint64_t>(FaceOwner::Quad) * 16 + 128;
  switch (owner) {
    case FaceOwner::Tet: return for_each_cell_face<CellKind::Tet>(mesh.tet_to_vert[element], element, body);
    case FaceOwner::Pyramid: return for_each_cell_face<CellKind::Pyramid>(mesh.pyramid_to_vert[element], element, body);
    case FaceOwner::Prism: return for_each_cell_face<CellKind::Prism>(mesh.prism_to_vert[element], element, body);
    case FaceOwner::Hex: return for_each_cell_face<CellKind::Hex>(mesh.hex_to_vert[element], element, body);
    case FaceOwner::Triangle: {
      const auto& v = mesh.tri_to_vert[element];
      return body(sorted_face(v[0], v[1], v[2]), element * 256 + triangle);
    }
    case FaceOwner::Quad: {
      const auto& v = mesh.quad_to_vert[element];
      return body(sorted_face(v[0], v[1], v[2], v[3]), element * 256 + quad);
    }
  }
}

/// How many elements have faces, by FaceOwner.
inline std::array<std::size_t, 6> count_face_owners(const Mesh& mesh) {
  return {mesh.tet_to_vert.size(), mesh.pyramid_to_vert.size(), mesh.prism_to_vert.size(),
          mesh.hex_to_vert.size(), mesh.tri_to_vert.size(),     mesh.quad_to_vert.size()};
}

/// Calls body(owner, element) for the elements from number `begin` to `end`, counted through all kinds.
template <class Body>
void for_each_face_owner(const std::array<std::size_t, 6>& counts, std::size_t begin, std::size_t end,
                         const Body& body) {
  std::size_t first = 0;
  for (std::size_t owner = 0; owner < counts.size(); first += counts[owner++])
    for (std::size_t i = std::max(begin, first); i < std::min(end, first + counts[owner]); ++i)
      body(static_cast<FaceOwner>(owner), i - first);
}

/// Calls body(low) for the lowest vertices of all faces of an element, some of them perhaps several times.
template <class Body>
void for_each_low_vertex(const Mesh& mesh, FaceOwner owner, std::uint64_t element, const Body& body) {
  if (owner != FaceOwner::Tet)
    return for_each_face_of(mesh, owner, element, [&](const SortedFace& face, std::uint64_t) { body(face.low); });
  // The two lowest of the vertices.
  const auto [a, b, c, d] = mesh.tet_to_vert[element];
  const auto [low_ab, high_ab] = std::minmax({a, b});
  const auto [low_cd, high_cd] = std::minmax({c, d});
  body(std::min(low_ab, low_cd));
  body(std::min(std::max(low_ab, low_cd), std::min(high_ab, high_cd)));
}

/// Calls file(range, element) once for every range that holds the lowest vertex of one of its faces.
template <class File>
void file_by_low_vertices(const Mesh& mesh, FaceOwner owner, std::uint64_t element, const KeyRanges& ranges,
                          const File& file) {
  std::array<std::size_t, 6> known;  // a hexahedron has six faces
  std::size_t count = 0;
  for_each_low_vertex(mesh, owner, element, [&](std::uint32_t low) {
    const std::size_t range = ranges.of(low);
    for (std::size_t i = 0; i < count; ++i)
      if (known[i] == range) return;
    known[count++] = range;
    file(range, element * 8 + static_cast<std::uint64_t>(owner));
  });
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

/// Sorts `bucket`, of faces with the lowest vertex `low`, and calls visit(low, uses) for each cycle among them.
template <class Visit>
void visit_cycles(const Mesh& mesh, std::uint32_t low, std::span<FaceUse> bucket, const Visit& visit) {
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

/// Calls visit(low, uses, result) for every cycle of three or four points that is a face of a cell or a surface
/// element; `uses` are ascending. `results` are copies of `blank`, one for each of some ranges of lowest points, and
/// are returned in their order. Within a range cycles come by lowest point.
template <class Result, class Visit>
std::vector<Result> map_face_groups(const Mesh& mesh, const BlockLoop& loop, const Result& blank, const Visit& visit) {
  const KeyRanges ranges(mesh.points.size());
  std::vector<Result> results(ranges.count(), blank);
  const std::array<std::size_t, 6> counts = count_face_owners(mesh);
  const auto emit = [&](std::size_t begin, std::size_t end, const auto& file) {
    for_each_face_owner(counts, begin, end, [&](FaceOwner owner, std::size_t element) {
      file_by_low_vertices(mesh, owner, element, ranges, file);
    });
  };
  const auto visit_range = [&](std::size_t range, std::span<const std::uint64_t> filed) {
    KeyBuckets<FaceUse> buckets(ranges.first(range), ranges.last(range));
    const auto for_each_use = [&](const auto& body) {
      for (const std::uint64_t owner : filed)
        for_each_face_of(mesh, static_cast<FaceOwner>(owner % 8), owner / 8,
                         [&](const SortedFace& face, std::uint64_t code) {
                           if (buckets.covers(face.low)) body(face, code);
                         });
    };
    for_each_use([&](const SortedFace& face, std::uint64_t) { buckets.count(face.low); });
    buckets.end_counting();
    for_each_use([&](const SortedFace& face, std::uint64_t code) {
      buckets.add(face.low, {face.mid, face.high, code | (face.flipped ? 8u : 0u)});
    });
    buckets.for_each([&](std::uint32_t low, std::span<FaceUse> bucket) {
      visit_cycles(mesh, low, bucket,
                   [&](std::uint32_t lowest, std::span<const FaceUse> uses) { visit(lowest, uses, results[range]); });
    });
  };
  const std::size_t total = std::accumulate(counts.begin(), counts.end(), std::size_t{0});
  for_each_filed_range<std::uint64_t>(total, ranges, loop, emit, visit_range);
  return results;
}

}  // namespace tetloom::detail

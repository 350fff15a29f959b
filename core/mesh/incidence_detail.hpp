#pragma once
// Private to core: finding shared edges and faces by grouping them under their lowest vertex, in windows of vertices
// that bound the working memory whatever the size of the mesh.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace tetloom::detail {

/// Local vertices of the face opposite to each vertex of a positive tet, counter-clockwise seen from outside.
inline constexpr std::array<std::array<int, 3>, 4> kTetFace{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// Local vertices of the edges; pairs k and 5 - k lie opposite to each other.
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

/// A face of a tet or a triangle, filed under its lowest vertex.
struct FaceUse {
  std::uint32_t mid = 0, high = 0;  ///< the other two vertices, mid <= high
  std::uint64_t code = 0;           ///< element * 16 + is_triangle * 8 + flipped * 4 + local face

  std::size_t element() const { return static_cast<std::size_t>(code >> 4); }
  bool is_triangle() const { return (code & 8) != 0; }
  /// Whether (low, mid, high) runs against the element's own orientation (outward for a tet).
  bool flipped() const { return (code & 4) != 0; }
  int local_face() const { return static_cast<int>(code & 3); }
  friend bool operator<(const FaceUse& a, const FaceUse& b) {
    if (a.mid != b.mid) return a.mid < b.mid;
    if (a.high != b.high) return a.high < b.high;
    return a.code < b.code;
  }
};

/// Three vertices in ascending order and whether that took an odd permutation.
struct SortedTriple {
  std::uint32_t low, mid, high;
  bool flipped;
};
inline SortedTriple sorted_triple(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  bool flipped = false;
  if (a > b) std::swap(a, b), flipped = !flipped;
  if (b > c) std::swap(b, c), flipped = !flipped;
  if (a > b) std::swap(a, b), flipped = !flipped;
  return {a, b, c, flipped};
}

/// Calls visit(low, uses) for every set of three points that is a face of a tet or a triangle; `uses` are ascending.
template <class Visit>
void for_each_face_group(const Mesh& mesh, const Visit& visit) {
  constexpr std::size_t kLimit = std::size_t{1} << 23;  // 128 MiB of uses
  const auto for_each_use = [&](const auto& body) {
    for (std::uint64_t t = 0; t < mesh.tet_to_vert.size(); ++t) {
      const auto& v = mesh.tet_to_vert[t];
      for (std::uint64_t f = 0; f < 4; ++f)
        body(sorted_triple(v[kTetFace[f][0]], v[kTetFace[f][1]], v[kTetFace[f][2]]), t * 16 + f);
    }
    for (std::uint64_t t = 0; t < mesh.tri_to_vert.size(); ++t) {
      const auto& v = mesh.tri_to_vert[t];
      body(sorted_triple(v[0], v[1], v[2]), t * 16 + 8);
    }
  };
  std::vector<std::uint32_t> counts(mesh.points.size(), 0);
  for_each_use([&](const SortedTriple& face, std::uint64_t) { ++counts[face.low]; });
  std::vector<FaceUse> storage;
  for (const Window& window : cut_windows(counts, kLimit)) {
    WindowBuckets<FaceUse> buckets(window, counts, storage);
    for_each_use([&](const SortedTriple& face, std::uint64_t code) {
      if (buckets.covers(face.low)) buckets.add(face.low, {face.mid, face.high, code | (face.flipped ? 4u : 0u)});
    });
    for (std::uint32_t low = window.first; low < window.last; ++low) {
      const std::span<FaceUse> bucket = buckets.bucket(low);
      std::sort(bucket.begin(), bucket.end());
      for (std::size_t begin = 0, end = 0; begin < bucket.size(); begin = end) {
        while (end < bucket.size() && bucket[end].mid == bucket[begin].mid && bucket[end].high == bucket[begin].high)
          ++end;
        visit(low, std::span<const FaceUse>(bucket.subspan(begin, end - begin)));
      }
    }
  }
}

}  // namespace tetloom::detail

#pragma once
// Faces of tets, and loops over them.
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>

#include "tetloom/ids.hpp"

namespace tetloom::tets {

/// One face of one tet, packed into one word as tet · 4 + side. Side i lies opposite of corner i, so that it stands for
/// that corner as well. Without a tet: nothing.
class FaceCode {
 public:
  constexpr FaceCode() = default;
  constexpr FaceCode(std::uint32_t tet, std::uint32_t side) : code_(tet * 4 + side) {}
  /// The face that stands at `index` in arrays of four entries per tet.
  static constexpr FaceCode at(std::size_t index) { return FaceCode(0, static_cast<std::uint32_t>(index)); }
  /// The four faces of a tet.
  static constexpr std::array<FaceCode, 4> of(std::uint32_t tet) {
    return {FaceCode(tet, 0), FaceCode(tet, 1), FaceCode(tet, 2), FaceCode(tet, 3)};
  }

  constexpr bool valid() const { return code_ != kNone; }
  constexpr std::uint32_t tet() const { return code_ / 4; }
  constexpr std::uint32_t side() const { return code_ % 4; }
  /// Where it stands in arrays of four entries per tet.
  constexpr std::size_t index() const { return code_; }
  /// The same face of another tet.
  constexpr FaceCode of_tet(std::uint32_t tet) const { return {tet, side()}; }
  friend constexpr auto operator<=>(FaceCode, FaceCode) = default;

 private:
  std::uint32_t code_ = kNone;
};

/// What `value` says of the four faces of a tet.
template <class Value>
constexpr auto of_faces(std::uint32_t tet, const Value& value) {
  const auto [a, b, c, d] = FaceCode::of(tet);
  return std::array{value(a), value(b), value(c), value(d)};
}

/// The faces of consecutive tets in their order, for loops.
class FaceRange {
 public:
  class Iterator {
   public:
    explicit constexpr Iterator(std::size_t at) : at_(at) {}
    constexpr FaceCode operator*() const { return FaceCode::at(at_); }
    constexpr Iterator& operator++() { return ++at_, *this; }
    friend constexpr bool operator==(Iterator, Iterator) = default;

   private:
    std::size_t at_;
  };

  constexpr FaceRange(std::size_t first_tet, std::size_t last_tet) : begin_(first_tet * 4), end_(last_tet * 4) {}
  constexpr Iterator begin() const { return Iterator(begin_); }
  constexpr Iterator end() const { return Iterator(end_); }

 private:
  std::size_t begin_, end_;
};

}  // namespace tetloom::tets

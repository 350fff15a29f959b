#pragma once
// Private to core/io: what a reader keeps that reads a slice of a file, in two passes: the tets, then all else.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/io/file_slice.hpp"
#include "core/io/formats_detail.hpp"

namespace tetloom::detail {

/// Elements that are kept have the numbers of the file's points until the end.
class SliceFilter {
 public:
  /// Pre: index < count.
  SliceFilter(std::size_t index, std::size_t count) : index_(index), count_(count) {}

  /// Whether the file, as far as it was read, can be read by slices.
  bool is_fit() const { return is_fit_; }
  void set_unfit() { is_fit_ = false; }

  /// Whether elements of the block are looked at in this pass.
  bool wants(Block block) const { return (block == Block::Tet) == is_first_pass_; }
  bool is_first_pass() const { return is_first_pass_; }

  /// That the file has `count` more of the block; of tets before the first of them all, in the first pass.
  void expect(Block block, std::uint64_t count);
  /// The same of points, all of them.
  void set_points(std::uint64_t count) { file_.points = count; }
  const FileCounts& counts() const { return file_; }

  /// Whether a tet of the file is one of the slice.
  bool keeps_tet(std::uint64_t number) const { return number >= first_tet_ && number < last_tet_; }
  /// Whether the point is one of those of the slice's tets; in the second pass.
  bool keeps_point(std::uint64_t point) const { return std::ranges::binary_search(points_, point); }
  /// Whether an element has such a point.
  template <std::size_t N>
  bool keeps(const std::array<std::uint32_t, N>& element) const {
    return std::ranges::any_of(element, [&](std::uint32_t v) { return keeps_point(v); });
  }

  /// The place of a point among those of the slice, one past the last for others; in the second pass.
  std::uint32_t local_of(std::uint64_t point) const;

  /// After the tets.
  void begin_second_pass(const Mesh& mesh);

  /// After all: the slice, if there is one. `points_are_classified`: else they are by what is kept, and by `corners`.
  std::optional<FileSlice> finish(Mesh&& mesh, std::span<const Corner> corners, bool points_are_classified);

 private:
  void renumber(Mesh& mesh) const;

  std::size_t index_, count_;
  bool is_first_pass_ = true, is_fit_ = true;
  FileCounts file_;
  std::uint64_t first_tet_ = 0, last_tet_ = 0;
  std::vector<std::uint64_t> points_;  // of the slice, ascending
};

/// What a slice of the file has; `filter` is new. Errors: InputUnreadable, Cancelled.
std::optional<FileSlice> read_vtu_slice(const InputFile& file, SliceFilter& filter);
std::optional<FileSlice> read_msh_slice(const InputFile& file, SliceFilter& filter);
std::optional<FileSlice> read_medit_text_slice(const InputFile& file, SliceFilter& filter);
std::optional<FileSlice> read_medit_binary_slice(const InputFile& file, SliceFilter& filter);

}  // namespace tetloom::detail

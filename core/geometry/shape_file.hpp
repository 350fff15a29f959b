#pragma once
// The shapes of a model in a file, from which each process reads those that it needs.
//
// A head, the shapes one after the other, and an index: where each of them lies, and what the writer has to say of them
// all. Private to this program and this machine: numbers lie as in memory, and nothing of it outlives a run.
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "tetloom/storage.hpp"

namespace tetloom {

/// Writes shapes to one file, one after the other.
class ShapeFileWriter {
 public:
  /// Errors: OutputFailed, of every member.
  explicit ShapeFileWriter(const std::filesystem::path& path);
  ~ShapeFileWriter();
  ShapeFileWriter(const ShapeFileWriter&) = delete;
  ShapeFileWriter& operator=(const ShapeFileWriter&) = delete;

  /// Shapes are numbered from 0, in the order in which they are added.
  void add(std::span<const std::byte> shape);
  void finish(std::span<const std::byte> description);

 private:
  void append(std::span<const std::byte> bytes);

  std::filesystem::path path_;
  int file_;
  std::vector<std::uint64_t> ends_;  // of the shapes
};

/// An opened file, which may be removed from its folder meanwhile. Thread safety: any number of threads.
class ShapeFile {
 public:
  /// Errors: InputUnreadable, of every member, also for another file.
  explicit ShapeFile(const std::filesystem::path& path);
  ~ShapeFile();
  ShapeFile(const ShapeFile&) = delete;
  ShapeFile& operator=(const ShapeFile&) = delete;

  Bytes read_description() const;
  std::size_t shape_count() const { return ends_.size(); }
  /// Of all shapes.
  std::uint64_t total_bytes() const;
  std::uint64_t bytes_of(std::size_t shape) const;
  Bytes read(std::size_t shape) const;

 private:
  void read_at(std::uint64_t place, std::span<std::byte> bytes) const;

  std::filesystem::path path_;
  int file_;
  std::vector<std::uint64_t> ends_;
  std::uint64_t description_bytes_ = 0;
};

}  // namespace tetloom

#include "core/geometry/shape_file.hpp"

#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>

#include "tetloom/error.hpp"

namespace tetloom {
namespace {

constexpr std::uint64_t kMagic = 0x7465746c53686170;

struct Head {
  std::uint64_t magic = 0, index = 0, shapes = 0, description = 0;  ///< where the index begins, and the lengths of both
};

[[noreturn]] void fail(ErrorCode code, const std::filesystem::path& path, const char* reason) {
  throw Error(code, "'" + path.string() + "', the file of a model's shapes: " + reason);
}

std::uint64_t begin_of(std::span<const std::uint64_t> ends, std::size_t shape) {
  return shape == 0 ? sizeof(Head) : ends[shape - 1];
}

}  // namespace

ShapeFileWriter::ShapeFileWriter(const std::filesystem::path& path)
    : path_(path), file_(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600)) {
  if (file_ < 0) fail(ErrorCode::OutputFailed, path_, std::strerror(errno));
  const Head unfinished;
  append(std::as_bytes(std::span(&unfinished, 1)));
}

ShapeFileWriter::~ShapeFileWriter() { ::close(file_); }

void ShapeFileWriter::append(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail(ErrorCode::OutputFailed, path_, std::strerror(errno));
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void ShapeFileWriter::add(std::span<const std::byte> shape) {
  append(shape);
  ends_.push_back(begin_of(ends_, ends_.size()) + shape.size());
}

void ShapeFileWriter::finish(std::span<const std::byte> description) {
  const Head head{kMagic, begin_of(ends_, ends_.size()), ends_.size(), description.size()};
  append(std::as_bytes(std::span(ends_)));
  append(description);
  if (::pwrite(file_, &head, sizeof(head), 0) != static_cast<ssize_t>(sizeof(head)))
    fail(ErrorCode::OutputFailed, path_, std::strerror(errno));
}

ShapeFile::ShapeFile(const std::filesystem::path& path)
    : path_(path), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (file_ < 0) fail(ErrorCode::InputUnreadable, path_, std::strerror(errno));
  try {
    Head head;
    read_at(0, std::as_writable_bytes(std::span(&head, 1)));
    const auto size = static_cast<std::uint64_t>(std::max<off_t>(::lseek(file_, 0, SEEK_END), 0));
    const bool fits = head.magic == kMagic && head.index <= size && head.shapes <= size / sizeof(std::uint64_t) &&
                      head.description <= size &&
                      head.index + head.shapes * sizeof(std::uint64_t) + head.description == size;
    if (!fits) fail(ErrorCode::InputUnreadable, path_, "it is incomplete, or something else");
    ends_.resize(head.shapes);
    read_at(head.index, std::as_writable_bytes(std::span(ends_)));
    description_bytes_ = head.description;
    const bool is_ascending = std::ranges::is_sorted(ends_) && begin_of(ends_, ends_.size()) == head.index;
    if (!is_ascending) fail(ErrorCode::InputUnreadable, path_, "its index does not fit");
  } catch (...) {
    ::close(file_);
    throw;
  }
}

ShapeFile::~ShapeFile() { ::close(file_); }

Bytes ShapeFile::read_description() const {
  Bytes bytes(description_bytes_);
  read_at(begin_of(ends_, ends_.size()) + ends_.size() * sizeof(std::uint64_t), bytes);
  return bytes;
}

std::uint64_t ShapeFile::bytes_of(std::size_t shape) const { return ends_[shape] - begin_of(ends_, shape); }

std::uint64_t ShapeFile::total_bytes() const { return begin_of(ends_, ends_.size()) - sizeof(Head); }

void ShapeFile::read_at(std::uint64_t place, std::span<std::byte> bytes) const {
  while (!bytes.empty()) {
    const ssize_t got = ::pread(file_, bytes.data(), bytes.size(), static_cast<off_t>(place));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail(ErrorCode::InputUnreadable, path_, got < 0 ? std::strerror(errno) : "it ends early");
    bytes = bytes.subspan(static_cast<std::size_t>(got));
    place += static_cast<std::uint64_t>(got);
  }
}

Bytes ShapeFile::read(std::size_t shape) const {
  if (shape >= ends_.size()) throw Error(ErrorCode::Internal, "a shape is asked for that was not stored");
  const std::uint64_t begin = begin_of(ends_, shape);
  Bytes bytes(ends_[shape] - begin);
  read_at(begin, bytes);
  return bytes;
}

}  // namespace tetloom

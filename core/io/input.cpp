#include <fcntl.h>
#include <locale.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "core/io/input_detail.hpp"

namespace tetloom::detail {
namespace {

/// Closes a file descriptor at the end of a scope.
class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return value_; }

 private:
  int value_;
};

}  // namespace

InputFile::InputFile(const std::filesystem::path& path, const CancelToken* cancel, FileAccess access)
    : name_("'"), cancel_(cancel) {
  name_ += path.string();
  name_ += '\'';
  const auto fail_with = [&](int reason) {
    throw Error(ErrorCode::InputUnreadable, "cannot read " + name_ + ": " + std::generic_category().message(reason));
  };
  // O_NONBLOCK: opening a pipe must not wait for its other end.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0) fail_with(errno);
  struct stat info {};
  if (::fstat(file.get(), &info) != 0) fail_with(errno);
  if (S_ISDIR(info.st_mode)) fail_with(EISDIR);
  if (!S_ISREG(info.st_mode)) fail(ErrorCode::InputUnreadable, "is no regular file");
  if (info.st_size == 0) fail(ErrorCode::InputUnreadable, "the file is empty");
  const auto expected = static_cast<std::size_t>(info.st_size);
  if (access == FileAccess::Mapped) {
    void* const mapping = ::mmap(nullptr, expected, PROT_READ, MAP_PRIVATE, file.get(), 0);
    if (mapping == MAP_FAILED) fail_with(errno);
    begin_ = static_cast<const char*>(mapping), size_ = expected;
    return;
  }
  data_ = std::make_unique_for_overwrite<char[]>(expected);
  begin_ = data_.get();
  constexpr std::size_t kChunk = std::size_t{32} << 20;  // between two looks at the cancel flag
  while (size_ < expected) {
    check_cancelled();
    const ssize_t got = ::read(file.get(), data_.get() + size_, std::min(kChunk, expected - size_));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail_with(errno);
    if (got == 0) break;  // somebody cut the file meanwhile
    size_ += static_cast<std::size_t>(got);
  }
}

InputFile::~InputFile() {
  if (!data_ && begin_ != nullptr) ::munmap(const_cast<char*>(begin_), size_);
}

void InputFile::let_go() const {
  if (!data_) ::madvise(const_cast<char*>(begin_), size_, MADV_DONTNEED);
}

void InputFile::fail(const std::string& what, const char* where) const {
  fail(ErrorCode::InputUnreadable, what + ", at byte " + std::to_string(where - begin_));
}

void InputFile::fail_at_line(const std::string& what, const char* where) const {
  const auto lines = std::count(begin_, where, '\n');
  fail(ErrorCode::InputUnreadable, what + ", in line " + std::to_string(lines + 1));
}

void InputFile::fail(ErrorCode code, const std::string& what) const { throw Error(code, name_ + ": " + what); }

std::string_view Cursor::line() {
  const char* const begin = at_;
  const void* const found = std::memchr(at_, '\n', left());
  const char* stop = found == nullptr ? end_ : static_cast<const char*>(found);
  at_ = found == nullptr ? end_ : stop + 1;
  if (stop > begin && stop[-1] == '\r') --stop;
  return {begin, static_cast<std::size_t>(stop - begin)};
}

double Cursor::nearest(const char* begin, const char* end) {
  static const locale_t plain = ::newlocale(LC_ALL_MASK, "C", nullptr);  // whatever the host's locale is
  return ::strtod_l(std::string(begin, end).c_str(), nullptr, plain);
}

void Cursor::fail_parse() const {
  Cursor copy(*this);
  const std::string_view found = copy.token();
  if (found.empty()) file_->fail_at_line("the file ends where a number is expected", at_);
  std::string shown(found.substr(0, 20));
  for (char& c : shown)
    if (c < ' ' || c > '~') c = '?';
  file_->fail_at_line("'" + shown + "' is not the number expected", at_);
}

}  // namespace tetloom::detail

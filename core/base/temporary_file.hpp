#pragma once
// Files that outlive nobody, and their bytes in memory.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace tetloom {

/// An empty file of a name of its own in the folder for temporary files. Its name is gone with this object; whoever has
/// opened or mapped it keeps what is in it.
class TemporaryFile {
 public:
  /// `kind` becomes part of the name. Errors: OutputFailed.
  explicit TemporaryFile(const std::string& kind);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// The bytes of a file, to be read, for as long as somebody holds them: its pages, which all processes that map it have
/// in common. Null where there is no such file, or none of `bytes` bytes. Pre: bytes > 0.
std::shared_ptr<const std::byte> map_file(const std::filesystem::path& path, std::size_t bytes);

}  // namespace tetloom

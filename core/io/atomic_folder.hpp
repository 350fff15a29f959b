#pragma once
// Folders of files that appear all together or not at all.
#include <filesystem>
#include <functional>
#include <string>

namespace tetloom {

/// A folder under a temporary name, `.<owner>.<process>-folder<number>.tmp` beside the target, that takes the target's
/// place in `swap_in`. What it replaced is kept until the end of the object, so that `swap_back` can undo it. The
/// destructor removes whatever has the temporary name then.
///
/// A target that is there already is replaced only if all its files are ones that `is_replaceable` accepts by name, so
/// that nobody's other files are lost. Names of folders end in a slash.
///
/// Errors: Error(OutputFailed) with the system's reason. A process that is killed leaves its temporary behind.
class AtomicFolder {
 public:
  AtomicFolder(const std::filesystem::path& target, const std::string& owner,
               const std::function<bool(const std::string&)>& is_replaceable);
  ~AtomicFolder();
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  /// Where the files go before `swap_in`.
  const std::filesystem::path& temporary() const { return temporary_; }

  void swap_in();
  /// Pre: swap_in succeeded. Never throws: there is an error to report already.
  void swap_back() noexcept;

 private:
  std::filesystem::path target_, temporary_;
  bool replaced_ = false;  ///< the target was there before
};

}  // namespace tetloom

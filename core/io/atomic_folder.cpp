#include "core/io/atomic_folder.hpp"

#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <system_error>

#include "tetloom/error.hpp"

namespace tetloom {
namespace {

[[noreturn]] void fail(const char* what, const std::filesystem::path& path, int reason) {
  throw Error(ErrorCode::OutputFailed, std::string("cannot ") + what + " the folder '" + path.string() +
                                           "': " + std::generic_category().message(reason));
}

std::filesystem::path temporary_name(const std::filesystem::path& target, const std::string& owner) {
  // Every value is used once, so no order is needed.
  static std::atomic<unsigned> counter{0};
  const std::string number = std::to_string(counter.fetch_add(1, std::memory_order_relaxed));
  return target.parent_path() /
         ("." + owner.substr(0, 200) + "." + std::to_string(::getpid()) + "-folder" + number + ".tmp");
}

void require_replaceable(const std::filesystem::path& target,
                         const std::function<bool(const std::string&)>& is_replaceable) {
  std::error_code error;
  const auto status = std::filesystem::symlink_status(target, error);
  if (!std::filesystem::exists(status)) return;
  if (!std::filesystem::is_directory(status)) fail("make", target, EEXIST);
  std::filesystem::directory_iterator entry(target, error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    const std::string name = entry->path().filename().string() + (entry->is_directory() ? "/" : "");
    if (!is_replaceable(name))
      throw Error(ErrorCode::OutputFailed, "the folder '" + target.string() + "' would be replaced, but holds '" +
                                               name + "', which is no piece of a mesh");
  }
  if (error) fail("read", target, error.value());
}

}  // namespace

AtomicFolder::AtomicFolder(const std::filesystem::path& target, const std::string& owner,
                           const std::function<bool(const std::string&)>& is_replaceable)
    : target_(target) {
  require_replaceable(target, is_replaceable);
  do {
    temporary_ = temporary_name(target, owner);
    if (::mkdir(temporary_.c_str(), 0777) == 0) return;
  } while (errno == EEXIST);
  fail("make", target, errno);
}

AtomicFolder::~AtomicFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(temporary_, ignored);
}

void AtomicFolder::swap_in() {
  std::error_code error;
  replaced_ = std::filesystem::exists(target_, error);
  if (!replaced_) {
    if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail("make", target_, errno);
    return;
  }
  if (::renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) == 0) return;
  if (errno != EINVAL && errno != ENOSYS) fail("replace", target_, errno);
  // A file system that cannot exchange two names: one after the other.
  const std::filesystem::path aside = temporary_.string() + ".old.tmp";
  if (::rename(target_.c_str(), aside.c_str()) != 0) fail("replace", target_, errno);
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) {
    const int reason = errno;
    ::rename(aside.c_str(), target_.c_str());
    fail("replace", target_, reason);
  }
  ::rename(aside.c_str(), temporary_.c_str());
}

void AtomicFolder::swap_back() noexcept {
  if (!replaced_) {
    ::rename(target_.c_str(), temporary_.c_str());
    return;
  }
  if (::renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) == 0) return;
  std::error_code ignored;
  std::filesystem::remove_all(target_, ignored);
  ::rename(temporary_.c_str(), target_.c_str());
}

}  // namespace tetloom

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdint>

#include "core/io/atomic_file.hpp"
#include "tests/core/file_size_limit.hpp"
#include "tests/core/mesh_fixtures.hpp"
#include "tests/core/mesh_io_support.hpp"
#include "tetloom/io.hpp"

using namespace tetloom;
using test::error_of;
using test::file_content;
using test::FileSizeLimit;
using test::TemporaryFolder;

TEST_CASE("a file appears under its name only when it is committed") {
  const TemporaryFolder folder;
  const auto path = folder / "out.json";
  {
    AtomicFile file(path);
    file.write("text ");
    file.print(17);
    file.print(' ');
    file.print(0.1);
    CHECK(file.position() == 11);
    CHECK_FALSE(std::filesystem::exists(path));
    CHECK(folder.file_count() == 1);
    file.commit();
  }
  CHECK(file_content(path) == "text 17 0.1");
  CHECK(folder.file_count() == 1);
}

TEST_CASE("without a commit the old file stays and the temporary goes") {
  const TemporaryFolder folder;
  test::write_file(folder / "out", "old");
  { AtomicFile(folder / "out").write("new"); }
  CHECK(file_content(folder / "out") == "old");
  CHECK(folder.file_count() == 1);
}

TEST_CASE("much data in pieces of all sizes arrives as it was written") {
  const TemporaryFolder folder;
  std::string expected;
  AtomicFile file(folder / "out");
  for (std::size_t size = 1; size < 3'000'000; size = size * 3 + 1) {
    const std::string piece(size, static_cast<char>('a' + size % 26));
    file.write(piece);
    file.put(static_cast<std::uint64_t>(size));
    expected += piece;
    expected.append(reinterpret_cast<const char*>(&size), 8);
  }
  CHECK(file.position() == expected.size());
  file.commit();
  CHECK(file_content(folder / "out") == expected);
}

TEST_CASE("targets that cannot be written are refused at once, with the reason") {
  const TemporaryFolder folder;
  const auto refuse = [](const std::filesystem::path& path, const std::string& reason) {
    const Diagnostic error = error_of([&] { AtomicFile file(path); });
    CHECK(error.code == ErrorCode::OutputFailed);
    CHECK_THAT(error.message, Catch::Contains(reason));
  };
  refuse(folder / "missing/out.vtu", "No such file or directory");
  refuse(folder / ".", "Is a directory");
  refuse("", "Is a directory");
  test::write_file(folder / "file", "x");
  refuse(folder / "file/out.vtu", "Not a directory");
  if (std::filesystem::exists("/proc/self")) CHECK_THROWS_AS(AtomicFile("/proc/out.vtu"), Error);
  CHECK(folder.file_count() == 1);
}

TEST_CASE("a folder without permission to write is refused") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "locked");
  std::filesystem::permissions(folder / "locked",
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  if (::access((folder / "locked").c_str(), W_OK) == 0) {
    std::cout << "this user may write everywhere: skipped\n";
    return;
  }
  const Diagnostic error = error_of([&] { AtomicFile file(folder / "locked/out"); });
  CHECK_THAT(error.message, Catch::Contains("Permission denied"));
}

TEST_CASE("a full disk is reported, and the temporary removed") {
  const TemporaryFolder folder;
  test::write_file(folder / "out.vtu", "old");
  const Mesh mesh = test::make_box(20, 20, 20);
  const std::array<std::string, 5> names{"out.vtu", "out.msh", "out.mesh", "out.meshb", "out.stl"};
  for (const std::string& name : names) {
    INFO(name);
    // Also in the middle of the last buffer, which is written on commit.
    for (const rlim_t limit : {rlim_t{100}, rlim_t{60000}}) {
      const FileSizeLimit full(limit);
      const Diagnostic error = error_of([&] { write_mesh(mesh, folder / name); });
      CHECK(error.code == ErrorCode::OutputFailed);
      CHECK_THAT(error.message, Catch::Contains("File too large"));
    }
  }
  CHECK(folder.file_count() == 1);
  CHECK(file_content(folder / "out.vtu") == "old");
}

TEST_CASE("a device is written to directly and its errors are reported") {
  if (!std::filesystem::exists("/dev/full")) return;
  AtomicFile null("/dev/null");
  null.write("x");
  null.commit();
  CHECK(std::filesystem::is_character_file("/dev/null"));
  AtomicFile full("/dev/full");
  full.write("x");
  const Diagnostic error = error_of([&] { full.commit(); });
  CHECK(error.code == ErrorCode::OutputFailed);
  CHECK_THAT(error.message, Catch::Contains("No space left on device"));
}

TEST_CASE("a symbolic link is followed, and permissions of an old file are kept") {
  const TemporaryFolder folder;
  test::write_file(folder / "real", "old");
  ::chmod((folder / "real").c_str(), 0640);
  std::filesystem::create_symlink(folder / "real", folder / "link");
  AtomicFile file(folder / "link");
  file.write("new");
  file.commit();
  CHECK(std::filesystem::is_symlink(folder / "link"));
  CHECK(file_content(folder / "real") == "new");
  struct stat info {};
  REQUIRE(::stat((folder / "real").c_str(), &info) == 0);
  CHECK((info.st_mode & 07777) == 0640);
}

TEST_CASE("a cancelled write leaves nothing behind") {
  const TemporaryFolder folder;
  const Mesh mesh = test::make_box(10, 10, 10);
  CancelToken cancel;
  cancel.cancel();
  const Diagnostic error = error_of([&] { write_mesh(mesh, folder / "out.vtu", &cancel); });
  CHECK(error.code == ErrorCode::Cancelled);
  CHECK(folder.file_count() == 0);
}

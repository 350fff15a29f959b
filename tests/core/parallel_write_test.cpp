#include <fcntl.h>
#include <sys/stat.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <future>

#include "core/io/atomic_file.hpp"
#include "core/io/mesh_parts.hpp"
#include "core/io/mesh_piece.hpp"
#include "core/mesh/mesh_access.hpp"
#include "tests/core/file_size_limit.hpp"
#include "tests/core/mesh_io_support.hpp"
#include "tests/support/block_loops.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/io.hpp"

using namespace tetloom;
using test::BackwardsLoop;
using test::error_of;
using test::file_content;
using test::FileSizeLimit;
using test::TemporaryFolder;
using test::ThreadsLoop;

namespace {

const std::array<std::string, 5> kWritten{".vtu", ".msh", ".mesh", ".meshb", ".stl"};

/// Large enough for several blocks in every format, and for several batches of text.
Mesh large_mesh() {
  Mesh mesh = test::make_mixed_box(40, 40, 40, 3, true);
  mesh.point_fields.push_back({"height", 1, {}});
  for (const Vec3& point : mesh.points) mesh.point_fields[0].values.push_back(point.z / 7);
  return mesh;
}

std::string bytes_of(const Mesh& mesh, const std::string& extension, const BlockLoop& loop) {
  const TemporaryFolder folder;
  const auto path = folder / ("mesh" + extension);
  write_mesh(mesh, path, nullptr, loop);
  CHECK(folder.file_count() == 1);
  return file_content(path);
}

/// Raises a flag in the middle of the loop that follows some others.
class CancellingLoop : public BlockLoop {
 public:
  CancellingLoop(CancelToken& cancel, int blocks) : cancel_(cancel), blocks_(blocks) {}
  void for_blocks(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) const override {
    threads_.for_blocks(count, grain, [&](std::size_t begin, std::size_t end) {
      if (--blocks_ == 0) cancel_.cancel();
      body(begin, end);
    });
  }

 private:
  CancelToken& cancel_;
  mutable std::atomic<int> blocks_;  // counted down by all threads; one of them sees 0
  ThreadsLoop threads_{3};
};

}  // namespace

TEST_CASE("files have the same bytes whoever carries out the loops, and hold the mesh") {
  const Mesh mesh = large_mesh();
  for (const std::string& extension : kWritten) {
    INFO(extension);
    const std::string expected = bytes_of(mesh, extension, serial_loop());
    CHECK(expected.size() > 500'000);
    CHECK(bytes_of(mesh, extension, BackwardsLoop()) == expected);
    CHECK(bytes_of(mesh, extension, ThreadsLoop(7)) == expected);
    if (extension == ".stl") continue;
    const TemporaryFolder folder;
    write_mesh(mesh, folder / ("mesh" + extension), nullptr, ThreadsLoop(3));
    test::check_same_elements(read_mesh(folder / ("mesh" + extension)), mesh);
  }
}

TEST_CASE("parts and pieces have the same bytes whoever carries out the loops") {
  const Mesh mesh = large_mesh();
  MeshParts parts{5, {}};
  for (std::size_t cell = 0; cell < cell_count(mesh); ++cell)
    parts.cell_to_part.push_back(static_cast<std::uint32_t>(cell * 2654435761u / 1000 % 5));
  std::vector<std::uint64_t> ids(mesh.points.size());
  for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = 3 * i;
  const TemporaryFolder folder;
  write_msh_parts(mesh, parts, folder / "a.msh");
  write_msh_parts(mesh, parts, folder / "b.msh", nullptr, ThreadsLoop(4));
  write_msh_parts(mesh, parts, folder / "c.msh", nullptr, BackwardsLoop());
  CHECK(file_content(folder / "b.msh") == file_content(folder / "a.msh"));
  CHECK(file_content(folder / "c.msh") == file_content(folder / "a.msh"));
  MeshParts read;
  test::check_same_elements(read_msh_parts(folder / "b.msh", read), mesh);
  CHECK(read.cell_to_part == parts.cell_to_part);
  write_mesh_piece(mesh, ids, folder / "a.vtu");
  write_mesh_piece(mesh, ids, folder / "b.vtu", nullptr, ThreadsLoop(4));
  CHECK(file_content(folder / "b.vtu") == file_content(folder / "a.vtu"));
}

TEST_CASE("a disk that becomes full while several threads write is reported, and the temporary removed") {
  const TemporaryFolder folder;
  const Mesh mesh = large_mesh();
  for (const std::string& extension : kWritten) {
    if (extension == ".stl") continue;
    for (const rlim_t limit : {rlim_t{2'000'000}, rlim_t{4'000'000}}) {
      INFO(extension << " up to " << limit);
      const FileSizeLimit full(limit);
      const Diagnostic error =
          error_of([&] { write_mesh(mesh, folder / ("out" + extension), nullptr, ThreadsLoop(4)); });
      CHECK(error.code == ErrorCode::OutputFailed);
      CHECK_THAT(error.message, Catch::Contains("File too large"));
      CHECK(folder.file_count() == 0);
    }
  }
}

TEST_CASE("a write that is cancelled in its middle leaves nothing behind") {
  const TemporaryFolder folder;
  const Mesh mesh = large_mesh();
  for (const std::string& extension : kWritten) {
    if (extension == ".stl") continue;
    for (const int blocks : {1, 25}) {
      INFO(extension << " after " << blocks);
      CancelToken cancel;
      const Diagnostic error =
          error_of([&] { write_mesh(mesh, folder / ("out" + extension), &cancel, CancellingLoop(cancel, blocks)); });
      CHECK(error.code == ErrorCode::Cancelled);
      CHECK(folder.file_count() == 0);
    }
  }
}

TEST_CASE("an exception of an encoder reaches the caller, and the file is gone") {
  const TemporaryFolder folder;
  for (const bool lines : {false, true}) {
    AtomicFile file(folder / "out");
    const auto fail_late = [](std::size_t begin) {
      if (begin > 400'000) throw std::runtime_error("late");
    };
    const auto write = [&] {
      if (lines)
        file.write_lines(
            1'000'000, 8, [&](std::size_t begin, std::size_t, char* out) { return fail_late(begin), out; },
            ThreadsLoop(3));
      else
        file.put_each(
            1'000'000, [&](std::size_t i) { return fail_late(i), std::uint64_t{i}; }, ThreadsLoop(3));
    };
    CHECK_THROWS_WITH(write(), "late");
    CHECK(folder.file_count() == 0);
  }
}

TEST_CASE("a pipe gets the same bytes in their order from several threads") {
  const TemporaryFolder folder;
  const Mesh mesh = large_mesh();
  for (const std::string& extension : {std::string(".msh"), std::string(".mesh")}) {
    INFO(extension);
    const auto path = folder / ("pipe" + extension);
    REQUIRE(::mkfifo(path.c_str(), 0600) == 0);
    std::future<std::string> content = std::async(std::launch::async, [&] { return file_content(path); });
    write_mesh(mesh, path, nullptr, ThreadsLoop(4));
    CHECK(content.get() == bytes_of(mesh, extension, serial_loop()));
  }
}

TEST_CASE("records and lines of all lengths follow what was written before them") {
  const TemporaryFolder folder;
  AtomicFile file(folder / "out");
  std::string expected;
  for (const std::size_t count : {0, 1, 1000, 90'000, 700'000}) {
    file.write("|");
    file.put_each(
        count, [](std::size_t i) { return static_cast<std::uint32_t>(i); }, ThreadsLoop(3));
    expected += '|';
    for (std::uint32_t i = 0; i < count; ++i) expected.append(reinterpret_cast<const char*>(&i), 4);
    file.write_lines(
        count, 3,
        [](std::size_t begin, std::size_t end, char* out) {
          for (std::size_t i = begin; i < end; ++i)
            for (std::size_t k = 0; k <= i % 3; ++k) *out++ = static_cast<char>('a' + i % 26);
          return out;
        },
        ThreadsLoop(3));
    for (std::size_t i = 0; i < count; ++i) expected.append(1 + i % 3, static_cast<char>('a' + i % 26));
    CHECK(file.position() == expected.size());
  }
  file.commit();
  CHECK(file_content(folder / "out") == expected);
}

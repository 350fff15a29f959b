// One copy of what all ranks of a machine have.
#include "threading/comm/copy_of_machine.hpp"

#include <stdlib.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.hpp"
#include "threading/comm/simulated_ranks.hpp"

using namespace tetloom;

namespace {

/// A folder for temporary files, for as long as this lives.
class TemporaryFilesIn {
 public:
  explicit TemporaryFilesIn(const std::string& folder) {
    if (const char* before = ::getenv("TMPDIR")) before_ = before;
    ::setenv("TMPDIR", folder.c_str(), 1);
  }
  ~TemporaryFilesIn() { before_ ? ::setenv("TMPDIR", before_->c_str(), 1) : ::unsetenv("TMPDIR"); }

 private:
  std::optional<std::string> before_;
};

std::vector<std::uint32_t> numbers(std::size_t count) {
  std::vector<std::uint32_t> values(count);
  std::iota(values.begin(), values.end(), 7u);
  return values;
}

/// What each of three ranks has of an array that all of them had.
std::vector<std::shared_ptr<const std::byte>> keep_on_ranks(std::span<const std::uint32_t> values) {
  std::vector<std::shared_ptr<const std::byte>> kept(3);
  on_simulated_ranks(3, [&](Communicator& ranks) {
    kept[static_cast<std::size_t>(ranks.rank())] = copy_of_machine(ranks)(std::as_bytes(values));
  });
  return kept;
}

}  // namespace

TEST_CASE("ranks of a machine map one file, which has no name any more") {
  const test::TemporaryFolder folder;
  const TemporaryFilesIn temporary(folder.path().string());
  const std::vector<std::uint32_t> values = numbers(kLeastKept);
  const auto kept = keep_on_ranks(values);
  CHECK(folder.file_count() == 0);
  for (const auto& bytes : kept) {
    REQUIRE(bytes);
    CHECK(std::equal(values.begin(), values.end(), reinterpret_cast<const std::uint32_t*>(bytes.get())));
  }
}

TEST_CASE("a fixed array is its bytes wherever these are kept") {
  const std::vector<std::uint32_t> values = numbers(kLeastKept);
  on_simulated_ranks(2, [&](Communicator& ranks) {
    FixedArray<std::uint32_t> array(values);
    const std::uint32_t* const own = array.data();
    array.move_to(copy_of_machine(ranks));
    const FixedArray<std::uint32_t> copy = array;
    array = {};
    if (copy.data() == own || !std::ranges::equal(copy.span(), values)) throw std::runtime_error("other values");
  });
}

TEST_CASE("few bytes, a rank alone and a machine without a folder for files keep what they have") {
  const std::vector<std::uint32_t> many = numbers(kLeastKept), few = numbers(10);
  for (const auto& bytes : keep_on_ranks(few)) CHECK(!bytes);
  for (const auto& bytes : keep_on_ranks({})) CHECK(!bytes);
  on_simulated_ranks(1, [&](Communicator& ranks) {
    if (copy_of_machine(ranks)(std::as_bytes(std::span(many)))) throw std::runtime_error("one rank has a file");
  });
  const TemporaryFilesIn nowhere("/no/such/folder");
  for (const auto& bytes : keep_on_ranks(many)) CHECK(!bytes);
}

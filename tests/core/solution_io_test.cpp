// Files of solutions: what is written is read back, files of others are read, bad ones are refused.
#include "tetloom/io.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "core/io/input_detail.hpp"
#include "tests/core/mesh_io_support.hpp"
#include "tests/support/block_loops.hpp"

using namespace tetloom;
using test::error_of;
using test::file_content;
using test::TemporaryFolder;

namespace {

constexpr SolutionSize kSize{5, 2};

Solution make_solution() {
  std::mt19937 random(3);
  const auto field = [&](const char* name, int components, std::size_t count) {
    MeshField made{name, components, {}};
    for (std::size_t i = 0; i < count * static_cast<std::size_t>(components); ++i)
      made.values.push_back(std::ldexp(static_cast<double>(random()), static_cast<int>(i % 40) - 50));
    return made;
  };
  Solution made;
  made.point_fields = {field("solution_1", 1, 5), field("solution_2", 6, 5), field("solution_3", 3, 5),
                       field("solution_4", 9, 5)};
  made.tet_fields = {field("solution_1", 1, 2)};
  made.point_fields[0].values[3] = std::numeric_limits<double>::quiet_NaN();
  made.point_fields[0].values[4] = -std::numeric_limits<double>::infinity();
  return made;
}

Diagnostic reading_error(const std::string& extension, const std::string& content, SolutionSize size = kSize) {
  const TemporaryFolder folder;
  const auto path = folder.write(test::joined("bad", extension), content);
  return error_of([&] { static_cast<void>(read_solution(path, size)); });
}

std::string content_of(const Solution& solution, const std::string& extension) {
  const TemporaryFolder folder;
  write_solution(solution, kSize, folder / test::joined("good", extension));
  return file_content(folder / test::joined("good", extension));
}

/// Builds a binary file by hand, of any version and byte order.
struct Bytes {
  std::string text;
  bool swap = false;
  template <class Number>
  Bytes& put(Number value) {
    if (swap) value = detail::byte_swapped(value);
    text.append(reinterpret_cast<const char*>(&value), sizeof(Number));
    return *this;
  }
  Bytes& position(std::uint64_t value, int version) {
    return version >= 3 ? put(value) : put(static_cast<std::uint32_t>(value));
  }
  Bytes& integer(std::int64_t value, int version) {
    return version == 4 ? put(value) : put(static_cast<std::int32_t>(value));
  }
  Bytes& real(double value, int version) { return version == 1 ? put(static_cast<float>(value)) : put(value); }
};

/// Two vertices with a scalar and a vector each, behind a keyword of no interest: 64, solutions on triangles.
std::string foreign_file(int version, bool swap) {
  Bytes bytes;
  bytes.swap = swap;
  const std::size_t position = version >= 3 ? 8 : 4, integer = version == 4 ? 8 : 4, real = version == 1 ? 4 : 8;
  bytes.put(std::int32_t{1}).put(std::int32_t{version});
  bytes.put(std::int32_t{3}).position(8 + 4 + position + 4, version).put(std::int32_t{3});
  bytes.put(std::int32_t{64}).position(bytes.text.size() + position + 3, version);
  bytes.text += "???";
  bytes.put(std::int32_t{62}).position(bytes.text.size() + position + integer + 12 + 8 * real, version);
  bytes.integer(2, version).put(std::int32_t{2}).put(std::int32_t{1}).put(std::int32_t{2});
  for (const double value : {0.5, 1., 2., 3., -0.25, 4., 5., 6.}) bytes.real(value, version);
  bytes.put(std::int32_t{54}).position(0, version);
  return bytes.text;
}

}  // namespace

TEST_CASE("solutions are read back bit for bit", "[solution_io]") {
  const TemporaryFolder folder;
  const Solution solution = make_solution();
  for (const char* name : {"a.sol", "a.solb", "b.SOL", "b.SolB"}) {
    INFO(name);
    write_solution(solution, kSize, folder / name);
    const Solution again = read_solution(folder / name, kSize);
    CHECK(test::same_fields(again.point_fields, solution.point_fields));
    CHECK(test::same_fields(again.tet_fields, solution.tet_fields));
    const std::string bytes = file_content(folder / name);
    write_solution(solution, kSize, folder / name, nullptr, test::BackwardsLoop());
    CHECK(file_content(folder / name) == bytes);
  }
  CHECK(is_solution_extension("x/y.SOLB"));
  CHECK_FALSE(is_solution_extension("x/y.mesh"));
}

TEST_CASE("binary solutions of all versions and both byte orders are read", "[solution_io]") {
  const TemporaryFolder folder;
  for (int version = 1; version <= 4; ++version)
    for (const bool swap : {false, true}) {
      CAPTURE(version, swap);
      const auto path = folder.write("x.solb", foreign_file(version, swap));
      const Solution read = read_solution(path, {2, 7});
      REQUIRE(read.point_fields.size() == 2);
      CHECK(read.point_fields[0].components == 1);
      CHECK(read.point_fields[0].values == std::vector<double>{0.5, -0.25});
      CHECK(read.point_fields[1].values == std::vector<double>{1, 2, 3, 4, 5, 6});
      CHECK(read.tet_fields.empty());
    }
}

TEST_CASE("text solutions of others are read", "[solution_io]") {
  const TemporaryFolder folder;
  const auto path = folder.write("x.sol",
                                 "# made elsewhere\nMeshVersionFormatted\n2\n\nDimension\n3\n\nSolAtTriangles 1 1 1 "
                                 "7.5\nSolAtVertices\n2\n1 3\n\n1 0 2e0 0 0 +3\n4\t0 nan 0 0 1e-3\nSolAtTetrahedra\n1 "
                                 "1 1 5\n\nEnd");
  const Solution read = read_solution(path, {2, 1});
  REQUIRE(read.point_fields.size() == 1);
  CHECK(read.point_fields[0].components == 6);
  CHECK(read.point_fields[0].values[2] == 2);
  CHECK(std::isnan(read.point_fields[0].values[8]));
  CHECK(read.point_fields[0].values[11] == 1e-3);
  REQUIRE(read.tet_fields.size() == 1);
  CHECK(read.tet_fields[0].values == std::vector<double>{5});
  const auto plane =
      folder.write("plane.sol", "MeshVersionFormatted 1 Dimension 2 SolAtVertices 1 2 2 3 1 2 3 4 5 End");
  CHECK(read_solution(plane, {1, 0}).point_fields[1].components == 3);
}

// The fields' values at these items of them all, and no others.
void check_values_at(const std::vector<std::uint64_t>& items, const std::vector<MeshField>& all,
                     const std::vector<MeshField>& some) {
  REQUIRE(some.size() == all.size());
  for (std::size_t f = 0; f < some.size(); ++f) {
    const auto n = static_cast<std::size_t>(all[f].components);
    REQUIRE(some[f].values.size() == items.size() * n);
    for (std::size_t i = 0; i < items.size() * n; ++i) {
      const double value = all[f].values[items[i / n] * n + i % n], read = some[f].values[i];
      CHECK((read == value || (std::isnan(read) && std::isnan(value))));
    }
  }
}

TEST_CASE("values are read at some points and tets alone", "[solution_io]") {
  const TemporaryFolder folder;
  const Solution solution = make_solution();
  for (const char* name : {"a.sol", "a.solb"}) {
    INFO(name);
    write_solution(solution, kSize, folder / name);
    const std::vector<std::uint64_t> points{1, kSize.points - 1};
    const Solution some = read_solution_at({points, kSize.tets - 1, 1}, folder / name, kSize);
    check_values_at(points, solution.point_fields, some.point_fields);
    check_values_at({kSize.tets - 1}, solution.tet_fields, some.tet_fields);
    const Solution none = read_solution_at({}, folder / name, kSize);
    check_values_at({}, solution.point_fields, none.point_fields);
    check_values_at({}, solution.tet_fields, none.tet_fields);
    const auto refused = [&](const SolutionShare& share) {
      return error_of([&] { static_cast<void>(read_solution_at(share, folder / name, kSize)); }).code ==
             ErrorCode::InvalidArgument;
    };
    for (const std::vector<std::uint64_t>& wrong : {std::vector<std::uint64_t>{1, 1}, {2, 1}, {kSize.points}})
      CHECK(refused({wrong, 0, 0}));
    CHECK(refused({points, 1, kSize.tets}));
    CHECK(refused({points, kSize.tets + 1, 0}));
  }
}

TEST_CASE("solutions that do not belong to the mesh are refused", "[solution_io]") {
  for (const char* extension : {".sol", ".solb"}) {
    const Diagnostic error = reading_error(extension, content_of(make_solution(), extension), {6, 2});
    CHECK(error.code == ErrorCode::InputUnsuitable);
    CHECK_THAT(error.message, Catch::Contains("values at 5 vertices, but the mesh has 6"));
  }
  CHECK(reading_error(".sol", "MeshVersionFormatted 2 Dimension 3 End").code == ErrorCode::InputUnsuitable);
  const auto of_kinds = [](const std::string& kinds) {
    return reading_error(".sol", "MeshVersionFormatted 2 Dimension 3 SolAtVertices 5 " + kinds + " 1 2 3 4 5 End");
  };
  CHECK_THAT(of_kinds("1 5").message, Catch::Contains("kind 5"));
  CHECK_THAT(of_kinds("1 -1").message, Catch::Contains("kind -1"));
  CHECK(of_kinds("0").code == ErrorCode::InputUnreadable);
  CHECK(of_kinds("1 2").code == ErrorCode::InputUnreadable);
  CHECK(of_kinds("99999999999 1").code == ErrorCode::InputUnreadable);
  CHECK(reading_error(".sol", "SolAtVertices 5 1 1 1 2 3 4 5").code == ErrorCode::InputUnreadable);
  CHECK(reading_error(".sol", "MeshVersionFormatted 2 Dimension 3 SolAtVertices 5 1 1 1 2 3 4 5").code ==
        ErrorCode::InputUnreadable);
  CHECK(reading_error(".sol", "MeshVersionFormatted 2 Dimension 4 End").code == ErrorCode::InputUnreadable);
  CHECK(reading_error(".txt", "").code == ErrorCode::InvalidArgument);
  CHECK(reading_error(".solb", "").code == ErrorCode::InputUnreadable);
}

TEST_CASE("a solution cut off anywhere is refused", "[solution_io]") {
  const TemporaryFolder folder;
  for (const char* extension : {".sol", ".solb"}) {
    const std::string whole = content_of(make_solution(), extension);
    const std::size_t needed = std::string(extension) == ".sol" ? whole.size() - 1 : whole.size() - 4;
    for (std::size_t size = 0; size < needed; ++size) {
      const auto path = folder.write(test::joined("cut", extension), whole.substr(0, size));
      const Diagnostic error = error_of([&] { static_cast<void>(read_solution(path, kSize)); });
      if (error.code != ErrorCode::InputUnreadable && error.code != ErrorCode::InputUnsuitable)
        FAIL_CHECK("cut to " << size << ": " << error.message);
    }
  }
}

TEST_CASE("a damaged solution is read or refused with a reason", "[solution_io]") {
  const unsigned seed = 99;
  CAPTURE(seed);
  std::mt19937 random(seed);
  const TemporaryFolder folder;
  for (const char* extension : {".sol", ".solb"}) {
    const std::string whole = content_of(make_solution(), extension);
    for (int i = 0; i < 1500; ++i) {
      std::string damaged = whole;
      for (unsigned k = 0; k <= random() % 3; ++k) damaged[random() % damaged.size()] = static_cast<char>(random());
      const auto path = folder.write(test::joined("damaged", extension), damaged);
      try {
        const Solution read = read_solution(path, kSize);
        for (const MeshField& field : read.point_fields)
          CHECK(field.values.size() == kSize.points * static_cast<std::size_t>(field.components));
      } catch (const Error& error) {
        CHECK((error.code() == ErrorCode::InputUnreadable || error.code() == ErrorCode::InputUnsuitable));
      }
    }
  }
}

TEST_CASE("solutions that no file can hold are not written", "[solution_io]") {
  const TemporaryFolder folder;
  const auto code_of = [&](const Solution& solution, const char* name) {
    return error_of([&] { write_solution(solution, kSize, folder / name); }).code;
  };
  CHECK(code_of({}, "x.sol") == ErrorCode::InvalidArgument);
  CHECK(code_of(make_solution(), "x.vtu") == ErrorCode::InvalidArgument);
  Solution wrong = make_solution();
  wrong.point_fields[1].values.pop_back();
  CHECK(code_of(wrong, "x.sol") == ErrorCode::InvalidArgument);
  wrong = {{{"pair", 2, std::vector<double>(10)}}, {}};
  CHECK(code_of(wrong, "x.solb") == ErrorCode::InvalidArgument);
  CHECK(folder.file_count() == 0);
}

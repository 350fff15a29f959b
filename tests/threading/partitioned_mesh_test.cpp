// Parts under random migrations: the whole mesh stays what it was, and every link names its copy from both sides.
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "core/part/convert.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/sanitized.hpp"
#include "tests/threading/communicators.hpp"
#include "tests/threading/disordering_communicator.hpp"
#include "tests/threading/part_cases.hpp"

using namespace tetloom;
using namespace tetloom::test;

namespace {

using Random = std::mt19937_64;

std::size_t random_part_count(Random& random) {
  constexpr std::size_t counts[] = {1, 2, 3, 7, 16, 40};
  return counts[random() % 6];
}

// The hashes of all parts after each of some migrations.
std::vector<std::vector<std::uint64_t>> migrate_and_hash(unsigned seed, Communicator& communicator, int threads) {
  const TaskRunner runner(threads);
  PartitionedMesh mesh = distribute_mesh(make_case(seed), communicator);
  std::vector<std::vector<std::uint64_t>> hashes{hash_parts(mesh)};
  Random random(seed);
  for (int round = 0; round < 5; ++round) {
    const std::size_t part_count = random_part_count(random);
    const Dealing dealing = dealing_of(random());
    migrate(mesh, deal(mesh, part_count, dealing, random()), part_count, runner);
    hashes.push_back(hash_parts(mesh));
  }
  return hashes;
}

}  // namespace

TEST_CASE("a mesh survives becoming a part and back") {
  for (const unsigned seed : {0u, 1u, 2u, 3u}) {
    const Mesh mesh = make_case(seed);
    const Whole expected = describe_whole(mesh), whole = describe_whole(make_mesh(make_part(mesh)));
    CHECK(whole.digest == expected.digest);
    CHECK(whole.fields == expected.fields);
    CHECK(whole.entities == expected.entities);
  }
}

TEST_CASE("a mesh that cannot be a part is refused on all ranks, and they stay in step") {
  const auto communicator = make_communicator();
  const Mesh good = make_case(1);
  Mesh bad = good;
  Diagnostic expected;
  SECTION("with an index beyond its points") {
    bad.tet_to_vert[0][2] = 1'000'000;
    expected.code = ErrorCode::InvalidArgument;
  }
  SECTION("with a triangle that belongs to no cell") {
    std::swap(bad.tri_to_vert[0][0], bad.tri_to_vert.back()[2]);
    expected.code = ErrorCode::InputUnsuitable;
  }
  SECTION("with a tag beyond what a part can hold") {
    bad.tet_to_entity[0] = (1u << 30) + 3;
    expected.code = ErrorCode::InputUnsuitable;
  }
  SECTION("with a point on an entity of such a tag") {
    bad.point_to_entity[0] = ModelEntity(0, 1u << 30);
    expected.code = ErrorCode::InputUnsuitable;
  }
  // What other ranks hold is not looked at, good or bad.
  for (const bool others_too : {false, true}) {
    const bool gives_bad = others_too || communicator->rank() == 0;
    const Diagnostic failure = error_of([&] { distribute_mesh(gives_bad ? bad : good, *communicator); });
    CHECK(failure.code == expected.code);
    CHECK_FALSE(failure.message.empty());
    PartitionedMesh mesh = distribute_mesh(communicator->rank() == 0 ? good : bad, *communicator);
    check_links(mesh, TaskRunner(1));
    check_whole(mesh, TaskRunner(1), describe_whole(good));
  }
}

TEST_CASE("random migrations leave the whole mesh as it was, and all links whole") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  const unsigned seeds = migration_seeds();
  for (unsigned seed = 0; seed < seeds; ++seed) {
    CAPTURE(seed);
    const Mesh original = make_case(seed);
    const Whole expected = describe_whole(original);
    PartitionedMesh mesh = distribute_mesh(original, *communicator);
    check_links(mesh, runner);
    Random random(seed);
    for (int round = 0; round < 5; ++round) {
      const std::size_t part_count = random_part_count(random);
      const Dealing dealing = dealing_of(random());
      CAPTURE(round, part_count, static_cast<int>(dealing));
      migrate(mesh, deal(mesh, part_count, dealing, random()), part_count, runner);
      CHECK(mesh.part_count() == part_count);
      check_links(mesh, runner);
    }
    check_whole(mesh, runner, expected);
  }
}

TEST_CASE("parts are the same to the bit on threads and on MPI ranks, however late messages come") {
  const auto communicator = make_communicator(), on_threads = make_thread_communicator();
  const unsigned seeds = kSanitized || communicator->rank_count() > 1 ? 6 : 24;
  for (unsigned seed = 0; seed < seeds; ++seed) {
    CAPTURE(seed);
    const auto expected = migrate_and_hash(seed, *on_threads, 1);
    CHECK(migrate_and_hash(seed, *communicator, 1 + static_cast<int>(seed % 3)) == expected);
    DisorderingCommunicator disordering(*communicator, seed);
    CHECK(migrate_and_hash(seed, disordering, 2) == expected);
  }
}

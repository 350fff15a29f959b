// Migrations that end early leave the mesh as it was, or are carried out whole.
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <random>
#include <thread>

#include "tests/support/mixed_mesh.hpp"
#include "tests/support/sanitized.hpp"
#include "tests/threading/communicators.hpp"
#include "tests/threading/part_cases.hpp"

using namespace tetloom;
using namespace tetloom::test;

namespace {

using Hashes = std::vector<std::uint64_t>;

// Raises a token when it is called for the n-th time, in whatever way.
class CancellingCommunicator : public Communicator {
 public:
  explicit CancellingCommunicator(Communicator& inner) : inner_(inner) {}
  void cancel_at(std::int64_t call, CancelToken& token) {
    calls_left_ = call;
    token_ = &token;
  }
  std::int64_t calls() const { return calls_; }

  int rank() const override { return inner_.rank(); }
  int rank_count() const override { return inner_.rank_count(); }
  void open(Receiver receiver) override { count(), inner_.open(std::move(receiver)); }
  void send(Message&& message, int rank) override { count(), inner_.send(std::move(message), rank); }
  void close() override { count(), inner_.close(); }
  void sum(std::span<std::int64_t> values) override { count(), inner_.sum(values); }
  void max(std::span<double> values) override { count(), inner_.max(values); }
  std::vector<Bytes> all_gather(Bytes bytes) override { return count(), inner_.all_gather(std::move(bytes)); }
  void announce_failure() override { count(), inner_.announce_failure(); }
  bool failed_elsewhere() const override { return inner_.failed_elsewhere(); }

 private:
  void count() {
    ++calls_;
    if (token_ != nullptr && calls_left_.fetch_sub(1) == 0) token_->cancel();
  }
  Communicator& inner_;
  CancelToken* token_ = nullptr;
  std::atomic<std::int64_t> calls_{0};             // counted by all threads that send; read when they are done
  std::atomic<std::int64_t> calls_left_{1 << 30};  // the same
};

constexpr std::size_t kBefore = 3, kAfter = 5;

PartitionedMesh make_parts(const Mesh& whole, Communicator& communicator) {
  PartitionedMesh mesh = distribute_mesh(whole, communicator);
  migrate(mesh, deal(mesh, kBefore, Dealing::Scatter, 1), kBefore, TaskRunner(2));
  return mesh;
}

PerPart<Destinations> next_deal(const PartitionedMesh& mesh) { return deal(mesh, kAfter, Dealing::Slabs, 2); }

// What a mesh in parts can be, both found whole.
struct Expected {
  explicit Expected(const Mesh& mesh, Communicator& communicator) : whole(describe_whole(mesh)) {
    PartitionedMesh parts = make_parts(mesh, communicator);
    const TaskRunner runner(2);
    before = hash_parts(parts);
    check_links(parts, runner);
    migrate(parts, next_deal(parts), kAfter, runner);
    after = hash_parts(parts);
    check_links(parts, runner);
    check_whole(parts, runner, whole);
  }
  Whole whole;
  Hashes before, after;
};

// The error that a migration ends with, if any.
std::optional<ErrorCode> try_to_migrate(PartitionedMesh& mesh, PerPart<Destinations> destinations,
                                        std::size_t part_count, const TaskRunner& runner) {
  try {
    migrate(mesh, std::move(destinations), part_count, runner);
  } catch (const Error& error) {
    return error.code();
  }
  return std::nullopt;
}

// Whether the mesh was migrated.
bool check_before_or_after(PartitionedMesh& mesh, std::optional<ErrorCode> error, const Expected& expected) {
  CHECK((!error || error == ErrorCode::Cancelled));
  std::int64_t cancelled[] = {error ? 1 : 0};
  mesh.communicator->sum(cancelled);
  CHECK((cancelled[0] == 0 || cancelled[0] == mesh.communicator->rank_count()));
  CHECK(hash_parts(mesh) == (error ? expected.before : expected.after));
  return !error;
}

}  // namespace

TEST_CASE("a migration with bad arguments leaves the mesh as it was") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  const Mesh whole = make_case(3);
  const Expected expected(whole, *communicator);
  const auto check_refusal = [&](PartId bad_part, const auto& spoil) {
    PartitionedMesh mesh = make_parts(whole, *communicator);
    PerPart<Destinations> destinations = next_deal(mesh);
    const bool here = destinations.is_local(bad_part);
    if (here) spoil(destinations.at(bad_part));
    const auto error = try_to_migrate(mesh, std::move(destinations), kAfter, runner);
    CHECK(error == ErrorCode::InvalidArgument);
    CHECK(mesh.part_count() == kBefore);
    CHECK(hash_parts(mesh) == expected.before);
  };
  for (std::size_t part = 0; part < kBefore; ++part) {
    check_refusal(PartId(part), [](Destinations& list) { list.back() = kAfter; });
    check_refusal(PartId(part), [](Destinations& list) { list.front() = 0xffffffffu; });
    check_refusal(PartId(part), [](Destinations& list) { list.pop_back(); });
    check_refusal(PartId(part), [](Destinations& list) { list.push_back(0); });
    check_refusal(PartId(part), [](Destinations& list) { list.clear(); });
  }
}

TEST_CASE("a mesh of no parts is refused") {
  const auto communicator = make_communicator();
  const Mesh whole = make_case(4);
  const Expected expected(whole, *communicator);
  PartitionedMesh mesh = make_parts(whole, *communicator);
  CHECK(try_to_migrate(mesh, next_deal(mesh), 0, TaskRunner(1)) == ErrorCode::InvalidArgument);
  CHECK(hash_parts(mesh) == expected.before);
}

TEST_CASE("wherever a migration is cancelled on one rank, all ranks have the mesh before or all that after") {
  const auto communicator = make_communicator();
  const Mesh whole = make_case(1);
  const Expected expected(whole, *communicator);
  const int rank = communicator->rank(), ranks = communicator->rank_count();
  std::array<std::int64_t, 2> outcomes{};
  const std::int64_t stride = kSanitized || ranks > 1 ? 13 : 1;
  double calls[] = {1};
  for (std::int64_t call = 0; call < static_cast<std::int64_t>(calls[0]); call += stride) {
    CAPTURE(call);
    CancellingCommunicator cancelling(*communicator);
    PartitionedMesh mesh = make_parts(whole, cancelling);
    CancelToken token;
    if (call % ranks == rank) cancelling.cancel_at(call, token);
    auto destinations = next_deal(mesh);
    const std::int64_t before = cancelling.calls();
    const auto error = try_to_migrate(mesh, std::move(destinations), kAfter, TaskRunner(2, {{}, &token}));
    calls[0] = static_cast<double>(cancelling.calls() - before);
    communicator->max(calls);
    if (error) calls[0] = static_cast<double>(call + stride + 1);
    ++outcomes[check_before_or_after(mesh, error, expected)];
  }
  CHECK(outcomes[0] > 0);
  CHECK(outcomes[1] > 0);
}

TEST_CASE("a migration cancelled at any time by another thread leaves the mesh before or that after") {
  const auto communicator = make_communicator();
  const Mesh whole = make_tet_box(8, 8, 8, 1);
  const Expected expected(whole, *communicator);
  std::mt19937 random(1);
  for (int attempt = 0; attempt < (kSanitized || communicator->rank_count() > 1 ? 8 : 40); ++attempt) {
    CAPTURE(attempt);
    PartitionedMesh mesh = make_parts(whole, *communicator);
    auto destinations = next_deal(mesh);
    CancelToken token;
    std::jthread canceller;
    const std::chrono::microseconds delay(random() % 6000);
    if (attempt % communicator->rank_count() == communicator->rank())
      canceller = std::jthread([&token, delay] {
        std::this_thread::sleep_for(delay);
        token.cancel();
      });
    check_before_or_after(mesh, try_to_migrate(mesh, std::move(destinations), kAfter, TaskRunner(2, {{}, &token})),
                          expected);
  }
}

#include "tetloom/assert.hpp"
#include "tetloom/communicator.hpp"

namespace tetloom {

namespace {

class ThreadCommunicator : public Communicator {
 public:
  int rank() const override { return 0; }
  int rank_count() const override { return 1; }

  void open(Receiver receiver) override {
    TETLOOM_ASSERT(!receiver_);
    receiver_ = std::move(receiver);
  }
  void send(Message&& message, int destination_rank) override {
    TETLOOM_ASSERT(destination_rank == 0 && receiver_);
    receiver_(std::move(message));
  }
  void close() override { receiver_ = nullptr; }

  void sum(std::span<std::int64_t>) override {}
  void max(std::span<double>) override {}
  std::vector<Bytes> all_gather(Bytes bytes) override {
    std::vector<Bytes> gathered;
    gathered.push_back(std::move(bytes));
    return gathered;
  }
  void announce_failure() override {}
  bool failed_elsewhere() const override { return false; }

 private:
  Receiver receiver_;
};

}  // namespace

std::unique_ptr<Communicator> make_thread_communicator() { return std::make_unique<ThreadCommunicator>(); }

}  // namespace tetloom

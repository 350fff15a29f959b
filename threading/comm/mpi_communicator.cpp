#include "tetloom/communicator.hpp"

#define OMPI_SKIP_MPICXX 1
#include <mpi.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <limits>
#include <mutex>
#include <numeric>
#include <string>
#include <thread>
#include <utility>

#include "tetloom/assert.hpp"
#include "threading/comm/collectives.hpp"
#include "threading/comm/frame_detail.hpp"

namespace tetloom {

namespace {

constexpr int kTag = 4711;
constexpr std::size_t kSmall = std::size_t{32} << 10;  // messages up to here share a frame

void check_mpi(int code, const char* what) {
  if (code == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING + 1] = {};
  int length = 0;
  MPI_Error_string(code, text, &length);
  throw Error(ErrorCode::Internal, std::string(what) + ": " + text);
}

/// Waits longer and longer while there is nothing to do: at first by giving way to other threads, then asleep.
class Patience {
 public:
  void reset() { tries_ = 0; }
  /// How long to sleep; zero: only give way.
  std::chrono::microseconds next() {
    ++tries_;
    if (tries_ < 100) return std::chrono::microseconds(0);
    return std::chrono::microseconds(std::min(1000, 20 + (tries_ - 100) * 5));
  }
  void wait() {
    const auto time = next();
    if (time.count() == 0)
      std::this_thread::yield();
    else
      std::this_thread::sleep_for(time);
  }

 private:
  int tries_ = 0;
};

void wait_for(MPI_Request request, const char* what) {
  int done = 0;
  for (Patience patience;;) {
    check_mpi(MPI_Test(&request, &done, MPI_STATUS_IGNORE), what);
    if (done) return;
    patience.wait();
  }
}

int count_ranks_on_machine(MPI_Comm all) {
  MPI_Comm machine;
  check_mpi(MPI_Comm_split_type(all, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine), "MPI_Comm_split_type");
  int count = 1;
  check_mpi(MPI_Comm_size(machine, &count), "MPI_Comm_size");
  check_mpi(MPI_Comm_free(&machine), "MPI_Comm_free");
  return count;
}

class MpiCommunicator : public Communicator {
 public:
  explicit MpiCommunicator(std::size_t largest_piece);
  ~MpiCommunicator() override;

  int rank() const override { return rank_; }
  int rank_count() const override { return rank_count_; }
  int ranks_on_machine() const override { return ranks_on_machine_; }
  std::uint64_t sent_bytes() const override { return sent_bytes_.load(std::memory_order_relaxed); }
  std::optional<int> mpi_handle() const override { return static_cast<int>(MPI_Comm_c2f(comm_)); }

  void open(Receiver receiver) override;
  void send(Message&& message, int destination_rank) override;
  void close() override;

  void sum(std::span<std::int64_t> values) override;
  void max(std::span<double> values) override;
  std::vector<Bytes> all_gather(Bytes bytes) override;
  void announce_failure() override;
  bool failed_elsewhere() const override { return failed_elsewhere_.load(std::memory_order_relaxed); }

 private:
  // All below is for the progress thread.
  void make_progress() noexcept;
  void begin_run();
  bool step();
  void rest(Patience& patience);
  bool take_outgoing();
  void ship(int destination, std::vector<Message>& messages);
  void ship_large(int destination, Message& message);
  void post(int destination, const std::shared_ptr<const Bytes>& bytes, std::size_t begin, std::size_t size);
  void post(int destination, Bytes frame);
  bool complete_sends();
  bool receive_frame();
  void receive_piece(int source, MPI_Message& handle, std::size_t size);
  void take_frame(int source, const Bytes& frame);
  void count_frame(std::uint64_t epoch);
  void hand_over(std::uint64_t epoch, Message&& message);
  void agree_on_end();
  bool is_over();

  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0, rank_count_ = 1, ranks_on_machine_ = 1;
  std::size_t largest_piece_;
  std::atomic<std::uint64_t> sent_bytes_{0};  // added to by any thread, a figure alone
  Receiver receiver_;
  std::uint64_t epoch_ = 0;
  std::thread progress_;
  std::exception_ptr broken_;  // written by the progress thread, read after it was joined

  std::mutex mutex_;  // around the queue of what other threads want sent, below
  std::condition_variable wake_;
  std::vector<std::vector<Message>> outgoing_;  // by rank
  bool has_outgoing_ = false, failure_to_announce_ = false, failure_announced_ = false, closing_ = false;
  // Raised by the progress thread on a failure frame, read by whoever runs steps; carries no data.
  std::atomic<bool> failed_elsewhere_{false};

  // Of the progress thread alone.
  std::vector<MPI_Request> requests_;                // of sends under way
  std::vector<std::shared_ptr<const Bytes>> bytes_;  // what each of them sends
  std::vector<detail::PartialMessage> partial_;      // by source
  std::vector<std::int64_t> frames_sent_, frames_expected_;
  std::int64_t frames_received_ = 0;
  MPI_Request end_request_ = MPI_REQUEST_NULL;
  bool ending_ = false, end_agreed_ = false;
  // Of the next run, sent by ranks that have left this one already.
  std::vector<Message> early_messages_;
  std::int64_t early_frames_ = 0;
  bool early_failure_ = false;
};

MpiCommunicator::MpiCommunicator(std::size_t largest_piece) : largest_piece_(largest_piece) {
  if (largest_piece == 0 || largest_piece > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw Error(ErrorCode::InvalidArgument, "the largest piece of a message must lie between 1 byte and 2 GiB");
  check_mpi(MPI_Comm_dup(MPI_COMM_WORLD, &comm_), "MPI_Comm_dup");
  check_mpi(MPI_Comm_set_errhandler(comm_, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
  check_mpi(MPI_Comm_rank(comm_, &rank_), "MPI_Comm_rank");
  check_mpi(MPI_Comm_size(comm_, &rank_count_), "MPI_Comm_size");
  ranks_on_machine_ = count_ranks_on_machine(comm_);
  const auto ranks = static_cast<std::size_t>(rank_count_);
  outgoing_.resize(ranks);
  partial_.resize(ranks);
  frames_expected_.resize(ranks);
}

MpiCommunicator::~MpiCommunicator() {
  if (progress_.joinable()) {
    {
      const std::lock_guard lock(mutex_);
      closing_ = true;
    }
    progress_.join();
  }
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (!finalized) MPI_Comm_free(&comm_);
}

void MpiCommunicator::open(Receiver receiver) {
  TETLOOM_ASSERT(!receiver_);
  if (broken_) std::rethrow_exception(broken_);
  receiver_ = std::move(receiver);
  closing_ = failure_to_announce_ = failure_announced_ = false;
  ++epoch_;
  failed_elsewhere_ = std::exchange(early_failure_, false);
  progress_ = std::thread([this] { make_progress(); });
}

void MpiCommunicator::send(Message&& message, int destination_rank) {
  if (destination_rank == rank_) return receiver_(std::move(message));
  sent_bytes_.fetch_add(message.bytes.size(), std::memory_order_relaxed);
  {
    const std::lock_guard lock(mutex_);
    outgoing_[static_cast<std::size_t>(destination_rank)].push_back(std::move(message));
    if (std::exchange(has_outgoing_, true)) return;
  }
  wake_.notify_one();
}

void MpiCommunicator::close() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  wake_.notify_one();
  progress_.join();
  receiver_ = nullptr;
  if (broken_) std::rethrow_exception(broken_);
}

void MpiCommunicator::announce_failure() {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(failure_announced_, true)) return;
    failure_to_announce_ = true;
  }
  wake_.notify_one();
}

void MpiCommunicator::sum(std::span<std::int64_t> values) {
  MPI_Request request;
  // Unsigned, so that sums of hashes may overflow.
  check_mpi(MPI_Iallreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_UINT64_T, MPI_SUM, comm_,
                           &request),
            "MPI_Iallreduce");
  wait_for(request, "MPI_Iallreduce");
}

void MpiCommunicator::max(std::span<double> values) {
  MPI_Request request;
  check_mpi(MPI_Iallreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_MAX, comm_,
                           &request),
            "MPI_Iallreduce");
  wait_for(request, "MPI_Iallreduce");
}

std::vector<Bytes> MpiCommunicator::all_gather(Bytes bytes) {
  std::vector<std::uint64_t> sizes(outgoing_.size());
  std::uint64_t size = bytes.size();
  if (rank_count_ > 1) sent_bytes_.fetch_add(size, std::memory_order_relaxed);
  MPI_Request request;
  check_mpi(MPI_Iallgather(&size, 1, MPI_UINT64_T, sizes.data(), 1, MPI_UINT64_T, comm_, &request), "MPI_Iallgather");
  wait_for(request, "MPI_Iallgather");
  std::vector<Bytes> gathered;
  run_on_all(*this, [&] {
    gathered.resize(sizes.size());
    for (std::size_t from = 0; from < sizes.size(); ++from)
      if (from != static_cast<std::size_t>(rank_)) gathered[from].resize_for_overwrite(sizes[from]);
  });
  gathered[static_cast<std::size_t>(rank_)] = std::move(bytes);
  for (std::size_t from = 0; from < sizes.size(); ++from)
    for (std::size_t begin = 0; begin < sizes[from]; begin += largest_piece_) {
      const auto piece = static_cast<int>(std::min<std::size_t>(largest_piece_, sizes[from] - begin));
      check_mpi(MPI_Ibcast(gathered[from].data() + begin, piece, MPI_BYTE, static_cast<int>(from), comm_, &request),
                "MPI_Ibcast");
      wait_for(request, "MPI_Ibcast");
    }
  return gathered;
}

void MpiCommunicator::make_progress() noexcept {
  try {
    begin_run();
    for (Patience patience; !is_over();) {
      if (step())
        patience.reset();
      else
        rest(patience);
    }
  } catch (...) {
    broken_ = std::current_exception();
    receiver_(Message{});
  }
}

void MpiCommunicator::begin_run() {
  frames_sent_.assign(outgoing_.size(), 0);
  frames_received_ = std::exchange(early_frames_, 0);
  ending_ = end_agreed_ = false;
  for (Message& message : std::exchange(early_messages_, {})) receiver_(std::move(message));
}

/// Does what there is to do; whether there was anything.
bool MpiCommunicator::step() {
  bool worked = take_outgoing();
  worked |= complete_sends();
  for (int i = 0; i < 64 && receive_frame(); ++i) worked = true;
  return worked;
}

void MpiCommunicator::rest(Patience& patience) {
  const auto time = patience.next();
  // What is on its way moves on only inside calls of MPI.
  if (time.count() == 0 || !requests_.empty()) return std::this_thread::yield();
  std::unique_lock lock(mutex_);
  wake_.wait_for(lock, time, [this] { return has_outgoing_ || failure_to_announce_ || (closing_ && !ending_); });
}

bool MpiCommunicator::take_outgoing() {
  std::vector<std::vector<Message>> taken(outgoing_.size());
  bool failure = false, any = false, ends = false;
  {
    const std::lock_guard lock(mutex_);
    failure = std::exchange(failure_to_announce_, false);
    any = std::exchange(has_outgoing_, false);
    if (any) taken.swap(outgoing_);
    ends = closing_ && !any && !failure && !ending_;
    if (ends) ending_ = true;
  }
  for (int rank = 0; failure && rank < rank_count_; ++rank)
    if (rank != rank_) post(rank, detail::failure_frame(epoch_));
  for (int rank = 0; any && rank < rank_count_; ++rank) ship(rank, taken[static_cast<std::size_t>(rank)]);
  if (ending_ && !end_agreed_ && end_request_ == MPI_REQUEST_NULL) agree_on_end();
  return any || failure || ends;
}

void MpiCommunicator::ship(int destination, std::vector<Message>& messages) {
  detail::FramePacker packer(epoch_);
  const auto flush = [&] {
    if (packer.size() > 0) post(destination, packer.take());
  };
  const std::size_t limit = std::min(kSmall, largest_piece_);
  for (Message& message : messages) {
    if (message.bytes.size() > limit) {
      flush();
      ship_large(destination, message);
    } else {
      packer.add(message);
      if (packer.size() > limit) flush();
    }
  }
  flush();
}

void MpiCommunicator::ship_large(int destination, Message& message) {
  post(destination, detail::large_frame(epoch_, message));
  const auto bytes = std::make_shared<const Bytes>(std::move(message.bytes));
  for (std::size_t begin = 0; begin < bytes->size(); begin += largest_piece_)
    post(destination, bytes, begin, std::min(largest_piece_, bytes->size() - begin));
}

void MpiCommunicator::post(int destination, Bytes frame) {
  const std::size_t size = frame.size();
  post(destination, std::make_shared<const Bytes>(std::move(frame)), 0, size);
}

void MpiCommunicator::post(int destination, const std::shared_ptr<const Bytes>& bytes, std::size_t begin,
                           std::size_t size) {
  bytes_.push_back(bytes);
  requests_.push_back(MPI_REQUEST_NULL);
  check_mpi(
      MPI_Isend(bytes->data() + begin, static_cast<int>(size), MPI_BYTE, destination, kTag, comm_, &requests_.back()),
      "MPI_Isend");
  ++frames_sent_[static_cast<std::size_t>(destination)];
}

bool MpiCommunicator::complete_sends() {
  if (requests_.empty()) return false;
  std::vector<int> done(requests_.size());
  int count = 0;
  check_mpi(
      MPI_Testsome(static_cast<int>(requests_.size()), requests_.data(), &count, done.data(), MPI_STATUSES_IGNORE),
      "MPI_Testsome");
  if (count <= 0) return false;
  for (int i = 0; i < count; ++i) bytes_[static_cast<std::size_t>(done[static_cast<std::size_t>(i)])] = nullptr;
  std::erase(requests_, MPI_REQUEST_NULL);
  std::erase(bytes_, nullptr);
  return true;
}

bool MpiCommunicator::receive_frame() {
  int there = 0, size = 0;
  MPI_Message handle;
  MPI_Status status;
  check_mpi(MPI_Improbe(MPI_ANY_SOURCE, kTag, comm_, &there, &handle, &status), "MPI_Improbe");
  if (!there) return false;
  check_mpi(MPI_Get_count(&status, MPI_BYTE, &size), "MPI_Get_count");
  const auto source = static_cast<std::size_t>(status.MPI_SOURCE);
  if (partial_[source].incomplete()) {
    receive_piece(status.MPI_SOURCE, handle, static_cast<std::size_t>(size));
  } else {
    Bytes frame;
    frame.resize_for_overwrite(static_cast<std::size_t>(size));
    check_mpi(MPI_Mrecv(frame.data(), size, MPI_BYTE, &handle, MPI_STATUS_IGNORE), "MPI_Mrecv");
    take_frame(status.MPI_SOURCE, frame);
  }
  return true;
}

void MpiCommunicator::receive_piece(int source, MPI_Message& handle, std::size_t size) {
  detail::PartialMessage& partial = partial_[static_cast<std::size_t>(source)];
  Bytes& bytes = partial.message.bytes;
  TETLOOM_ASSERT(size <= bytes.size() - partial.arrived);
  check_mpi(MPI_Mrecv(bytes.data() + partial.arrived, static_cast<int>(size), MPI_BYTE, &handle, MPI_STATUS_IGNORE),
            "MPI_Mrecv");
  partial.arrived += size;
  count_frame(partial.epoch);
  if (partial.incomplete()) return;
  detail::PartialMessage whole = std::exchange(partial, {});
  hand_over(whole.epoch, std::move(whole.message));
}

void MpiCommunicator::take_frame(int source, const Bytes& frame) {
  MessageReader reader(frame);
  const auto head = reader.get<detail::FrameHead>();
  count_frame(head.epoch);
  if (head.kind == detail::RankFrameKind::Failure) {
    (head.epoch == epoch_ ? failed_elsewhere_ = true : early_failure_ = true);
  } else if (head.kind == detail::RankFrameKind::Large) {
    detail::PartialMessage& partial = partial_[static_cast<std::size_t>(source)];
    partial = {detail::get_address(reader), head.epoch, 0};
    partial.message.bytes.resize_for_overwrite(reader.get<std::uint64_t>());
  } else {
    while (!reader.at_end()) {
      Message message = detail::get_address(reader);
      message.bytes = Bytes(reader.get_view<std::byte>());
      hand_over(head.epoch, std::move(message));
    }
  }
}

void MpiCommunicator::count_frame(std::uint64_t epoch) {
  // A rank leaves a run only after all have come to its end, so none is ahead by more than one.
  TETLOOM_ASSERT(epoch == epoch_ || epoch == epoch_ + 1);
  ++(epoch == epoch_ ? frames_received_ : early_frames_);
}

void MpiCommunicator::hand_over(std::uint64_t epoch, Message&& message) {
  if (epoch == epoch_)
    receiver_(std::move(message));
  else
    early_messages_.push_back(std::move(message));
}

/// Each rank tells each other how much it has sent it. No barrier is needed beside: nobody knows before all have told.
void MpiCommunicator::agree_on_end() {
  check_mpi(
      MPI_Ialltoall(frames_sent_.data(), 1, MPI_INT64_T, frames_expected_.data(), 1, MPI_INT64_T, comm_, &end_request_),
      "MPI_Ialltoall");
}

bool MpiCommunicator::is_over() {
  if (!ending_) return false;
  if (!end_agreed_) {
    int done = 0;
    check_mpi(MPI_Test(&end_request_, &done, MPI_STATUS_IGNORE), "MPI_Ialltoall");
    if (!done) return false;
    end_agreed_ = true;
  }
  const auto expected = std::accumulate(frames_expected_.begin(), frames_expected_.end(), std::int64_t{0});
  return requests_.empty() && frames_received_ == expected;
}

}  // namespace

MpiSession::MpiSession(int& argc, char**& argv) {
  int provided = 0;
  check_mpi(MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &provided), "MPI_Init_thread");
  if (provided < MPI_THREAD_SERIALIZED)
    throw Error(ErrorCode::Internal, "this MPI cannot be called from more than one thread");
}

MpiSession::~MpiSession() { MPI_Finalize(); }

std::unique_ptr<Communicator> make_mpi_communicator(std::size_t largest_piece) {
  return std::make_unique<MpiCommunicator>(largest_piece);
}

}  // namespace tetloom

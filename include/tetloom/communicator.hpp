#pragma once
// How ranks and parts talk, by threads and by MPI.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "tetloom/error.hpp"
#include "tetloom/ids.hpp"

// What one part sends to another in one step, and how values are put in and taken out.

namespace tetloom {

using PartId = Id<struct PartKind>;
using Bytes = std::vector<std::byte>;

/// `step` is the step that the message is for.
struct Message {
  PartId from, to;
  std::uint32_t step = 0;
  Bytes bytes;
};

/// Puts trivially copyable values and arrays into a buffer, each at a multiple of 8 bytes.
class MessageWriter {
 public:
  void reserve(std::size_t bytes) { bytes_.reserve(bytes); }
  bool empty() const { return bytes_.empty(); }

  template <class T>
  void put(const T& value) {
    std::memcpy(make_room<T>(1).data(), &value, sizeof(T));
  }
  /// The length and then the values.
  template <class T>
  void put_array(std::span<const T> values) {
    const std::span<T> room = put_room<T>(values.size());
    if (!values.empty()) std::memcpy(room.data(), values.data(), values.size_bytes());
  }
  /// The length, and room for the values that the caller fills in before anything else is put.
  template <class T>
  std::span<T> put_room(std::size_t count) {
    put(static_cast<std::uint64_t>(count));
    return make_room<T>(count);
  }
  /// The length, and `value(item)` for each of the items.
  template <class Items, class Value>
  void put_each(const Items& items, const Value& value) {
    using T = std::decay_t<decltype(value(*std::begin(items)))>;
    std::ranges::transform(items, put_room<T>(std::size(items)).begin(), value);
  }
  Bytes take() { return std::move(bytes_); }

 private:
  template <class T>
  std::span<T> make_room(std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= 8);
    const std::size_t before = bytes_.size();
    bytes_.resize(before + (count * sizeof(T) + 7) / 8 * 8);
    return {reinterpret_cast<T*>(bytes_.data() + before), count};
  }
  Bytes bytes_;
};

/// Takes out in the same order what a MessageWriter put in. Throws Error(Internal) when there is less than asked for.
/// Pre: the bytes begin at a multiple of 8.
class MessageReader {
 public:
  explicit MessageReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  bool at_end() const { return bytes_.empty(); }

  template <class T>
  T get() {
    T value;
    std::memcpy(&value, take<T>(1).data(), sizeof(T));
    return value;
  }
  /// The values where they lie; valid as long as the bytes are.
  template <class T>
  std::span<const T> get_view() {
    const auto count = get<std::uint64_t>();
    if (count > bytes_.size() / sizeof(T)) fail();
    return take<T>(static_cast<std::size_t>(count));
  }
  template <class T>
  std::vector<T> get_array() {
    const std::span<const T> view = get_view<T>();
    return {view.begin(), view.end()};
  }

 private:
  [[noreturn]] static void fail() {
    throw Error(ErrorCode::Internal, "a message between parts is shorter than it says");
  }
  template <class T>
  std::span<const T> take(std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= 8);
    const std::size_t padded = (count * sizeof(T) + 7) / 8 * 8;
    if (padded > bytes_.size()) fail();
    const std::span<const T> values(reinterpret_cast<const T*>(bytes_.data()), count);
    bytes_ = bytes_.subspan(padded);
    return values;
  }
  std::span<const std::byte> bytes_;
};

// How parts talk: messages between parts, collectives between ranks, and which rank hosts which part.

/// Carries the messages of a schedule and knows where parts live. Algorithms see parts and never which implementation
/// they run on: ThreadCommunicator hosts all parts in this process, MpiCommunicator several parts per MPI rank.
///
/// Parts are dealt to ranks in blocks: part p of P lives on rank floor(p · ranks / P), so it is never moved by a change
/// of the number of threads, and ranks without parts are allowed.
///
/// Laws: a message arrives exactly once, whole, with the bytes that were sent. Nothing is promised of the order of
/// arrival; whoever needs an order sorts by sender. Sums of integers do not depend on ranks or timing; floating-point
/// sums are not offered for that reason.
class Communicator {
 public:
  /// Called for each message that arrives, from any thread, possibly from inside `send`. Must not throw. A message to
  /// no part (`to` is not valid) says that the communicator is broken and that nothing more will come.
  using Receiver = std::function<void(Message&&)>;

  virtual ~Communicator() = default;

  virtual int rank() const = 0;
  virtual int rank_count() const = 0;
  /// How many ranks share this rank's machine and its cores, itself included.
  virtual int ranks_on_machine() const { return 1; }

  /// Opens a run of messages: from here to `close`, what arrives for a part of this rank goes to `receiver`. All ranks
  /// open together. A message that was sent by another rank before this one opened is kept and delivered.
  virtual void open(Receiver receiver) = 0;
  /// Thread-safe. Moves the bytes when the destination lives on this rank.
  virtual void send(Message&& message, int destination_rank) = 0;
  /// Waits until everything that was sent in the run has arrived and closes it. All ranks close together. Afterwards
  /// the receiver is called no more.
  virtual void close() = 0;

  /// Collectives: every rank calls them in the same order, by one thread at a time, outside of runs.
  virtual void sum(std::span<std::int64_t> values) = 0;
  virtual void max(std::span<double> values) = 0;
  /// What each rank gave, by rank.
  virtual std::vector<Bytes> all_gather(Bytes bytes) = 0;
  /// Raised when a rank fails inside a run: the others' runs end with an Error too instead of waiting for ever.
  virtual void announce_failure() = 0;
  virtual bool failed_elsewhere() const = 0;

  /// What MPI_Comm_c2f says of the communicator's own MPI communicator, for libraries that need one; nothing where the
  /// ranks are not MPI's.
  virtual std::optional<int> mpi_handle() const { return {}; }

  /// The rank that hosts part `part` of `part_count`.
  int rank_of(PartId part, std::size_t part_count) const {
    return static_cast<int>(std::uint64_t{part.value} * static_cast<std::uint64_t>(rank_count()) / part_count);
  }
  /// The parts that this rank hosts, ascending.
  std::vector<PartId> parts_of_rank(std::size_t part_count) const;
};

/// All parts in this process.
std::unique_ptr<Communicator> make_thread_communicator();

// Parts on several MPI ranks. Only where TETLOOM_MPI is on.

/// MPI from the beginning to the end of `main`. Errors: Error(Internal) when MPI cannot be called from changing
/// threads.
class MpiSession {
 public:
  MpiSession(int& argc, char**& argv);
  ~MpiSession();
  MpiSession(const MpiSession&) = delete;
  MpiSession& operator=(const MpiSession&) = delete;
};

/// Several parts on each rank of MPI_COMM_WORLD, over a duplicate of it. All ranks make and destroy it together, inside
/// a session (or after the host's own MPI_Init_thread with MPI_THREAD_SERIALIZED).
///
/// During a run a thread of the communicator's own makes all calls of MPI; the host makes none then. Messages are cut
/// into pieces of at most `largest_piece` bytes (below 2 GiB), the same on all ranks; a message may have any size.
std::unique_ptr<Communicator> make_mpi_communicator(std::size_t largest_piece = std::size_t{64} << 20);

}  // namespace tetloom

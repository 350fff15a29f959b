#pragma once
// How ranks and parts talk, by threads and by MPI.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "tetloom/error.hpp"
#include "tetloom/ids.hpp"
#include "tetloom/storage.hpp"

namespace tetloom {

using PartId = Id<struct PartKind>;

/// What one part sends to another in one step; `step` is the step that the message is for.
struct Message {
  PartId from, to;
  std::uint32_t step = 0;
  Bytes bytes;
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
  /// Bytes that this rank has given to others so far, in messages and in what it had gathered; those that it gave to
  /// all count once.
  virtual std::uint64_t sent_bytes() const { return 0; }

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

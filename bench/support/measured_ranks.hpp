#pragma once
// What each rank computes and sends between two meetings of all, measured on ranks that are threads of one process, and
// how long as many machines would take for it.
#include <cstdint>
#include <functional>
#include <vector>

#include "tetloom/communicator.hpp"

namespace tetloom::bench {

/// From one collective call of a rank to the next.
struct RankPhase {
  double seconds = 0;        ///< of the processor
  std::uint64_t bytes = 0;   ///< to other ranks
  bool is_gathered = false;  ///< all ranks get these bytes from all
};

/// By rank; all of them have as many phases.
using RankPhases = std::vector<std::vector<RankPhase>>;

/// What a network takes.
struct NetworkCosts {
  double latency = 1e-5;   ///< s, of a message
  double bandwidth = 1e9;  ///< bytes per second that a rank sends or gets
};

/// Runs `body` once for each rank, all at the same time, asleep while they wait. Ranks use one thread each. What
/// happens before a rank calls `start` is not in it. Rethrows as on_simulated_ranks.
RankPhases measure_ranks(int ranks, const std::function<void(Communicator&, const std::function<void()>& start)>& body);

/// In each phase all ranks wait for the one that computes longest and the one that sends most; a collective call takes
/// the latency of as many messages as the logarithm of the ranks, and what is gathered comes to each rank once.
double predict_seconds(const RankPhases& phases, const NetworkCosts& network);
/// The same without what is sent: ranks wait for each other alone.
double compute_seconds(const RankPhases& phases);
/// Of all ranks together.
double processor_seconds(const RankPhases& phases);
/// Of the rank that sends most; what is gathered counts once.
std::uint64_t most_sent_bytes(const RankPhases& phases);

}  // namespace tetloom::bench

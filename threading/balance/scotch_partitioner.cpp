#include <scotch.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "tetloom/error.hpp"
#include "threading/balance/graph_partitioners.hpp"

namespace {

// What Scotch said last on this thread. Each call of partition_scotch keeps to one thread.
thread_local std::string scotch_message;

void keep_message(const char* format, std::va_list arguments) {
  std::array<char, 512> text{};
  std::vsnprintf(text.data(), text.size(), format, arguments);
  scotch_message = text.data();
}

}  // namespace

extern "C" {
void SCOTCH_errorPrint(const char* const format, ...) {
  std::va_list arguments;
  va_start(arguments, format);
  keep_message(format, arguments);
  va_end(arguments);
}
void SCOTCH_errorPrintW(const char* const format, ...) {
  std::va_list arguments;
  va_start(arguments, format);
  keep_message(format, arguments);
  va_end(arguments);
}
}

namespace tetloom {

namespace {

constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<SCOTCH_Num>::max());

void check_scotch(int status, const char* what) {
  if (status != 0) throw Error(ErrorCode::Internal, std::string("Scotch could not ") + what + ": " + scotch_message);
}

/// One of Scotch's structures, from its init to its exit.
template <class T, int (*Init)(T*), void (*Exit)(T*)>
class Handle {
 public:
  Handle() { check_scotch(Init(&value_), "set up"); }
  ~Handle() { Exit(&value_); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  T* get() { return &value_; }

 private:
  T value_;
};
using ScotchGraph = Handle<SCOTCH_Graph, SCOTCH_graphInit, SCOTCH_graphExit>;
using Context = Handle<SCOTCH_Context, SCOTCH_contextInit, SCOTCH_contextExit>;
using Strategy = Handle<SCOTCH_Strat, SCOTCH_stratInit, SCOTCH_stratExit>;

void check_graph(const CellGraph& graph, std::uint32_t part_count, double imbalance, std::size_t targets) {
  const auto bad = [](const char* what) { throw Error(ErrorCode::InvalidArgument, what); };
  const std::size_t cells = graph.first.empty() ? 0 : graph.first.size() - 1;
  if (graph.first.empty() || graph.first.back() != graph.neighbours.size() || targets != cells ||
      (!graph.weights.empty() && graph.weights.size() != cells) ||
      (!graph.links.empty() && graph.links.size() != graph.neighbours.size()))
    bad("a graph of cells has arrays that do not fit");
  if (part_count == 0 || part_count > kMost || !(imbalance >= 0)) bad("there must be parts, and a bound on imbalance");
  if (graph.neighbours.size() >= kMost || cells >= kMost) bad("the graph is too large for Scotch's integers");
  const auto not_positive = [](std::int64_t weight) { return weight <= 0; };
  if (std::ranges::any_of(graph.weights, not_positive) || std::ranges::any_of(graph.links, not_positive))
    bad("weights must be positive");
  if (std::ranges::any_of(graph.neighbours, [&](std::uint32_t n) { return n >= cells; }))
    bad("a graph of cells names a cell that it does not have");
}

/// Weights whose sum is within Scotch's integers.
std::vector<SCOTCH_Num> small_weights(std::span<const std::int64_t> weights) {
  double sum = 0;
  for (const std::int64_t w : weights) sum += static_cast<double>(w);
  const double most = static_cast<double>(kMost) / 2 - static_cast<double>(weights.size());
  const double scale = sum > most ? most / sum : 1;
  std::vector<SCOTCH_Num> small(weights.size());
  std::ranges::transform(weights, small.begin(), [&](std::int64_t w) {
    return std::max<SCOTCH_Num>(1, static_cast<SCOTCH_Num>(static_cast<double>(w) * scale));
  });
  return small;
}

void prepare(Context& context) {
  check_scotch(SCOTCH_contextOptionSetNum(context.get(), SCOTCH_OPTIONNUMDETERMINISTIC, 1), "be made deterministic");
  check_scotch(SCOTCH_contextOptionSetNum(context.get(), SCOTCH_OPTIONNUMRANDOMFIXEDSEED, 1), "fix its seed");
  check_scotch(SCOTCH_contextRandomClone(context.get()), "take a generator of its own");
  SCOTCH_contextRandomSeed(context.get(), 20100614);
  SCOTCH_contextRandomReset(context.get());
  check_scotch(SCOTCH_contextThreadSpawn(context.get(), 1, nullptr), "keep to one thread");
}

}  // namespace

void partition_scotch(const CellGraph& graph, std::uint32_t part_count, double imbalance,
                      std::span<std::uint32_t> targets) {
  check_graph(graph, part_count, imbalance, targets.size());
  std::ranges::fill(targets, 0U);
  if (part_count == 1 || targets.empty()) return;
  const auto cells = static_cast<SCOTCH_Num>(targets.size());
  std::vector<SCOTCH_Num> first(graph.first.begin(), graph.first.end());
  std::vector<SCOTCH_Num> neighbours(graph.neighbours.begin(), graph.neighbours.end());
  const std::vector<SCOTCH_Num> weights = small_weights(graph.weights);
  const std::vector<SCOTCH_Num> links = small_weights(graph.links);
  std::vector<SCOTCH_Num> parts(targets.size());
  Context context;
  prepare(context);
  ScotchGraph plain, bound;
  Strategy strategy;
  check_scotch(
      SCOTCH_graphBuild(plain.get(), 0, cells, first.data(), nullptr, weights.empty() ? nullptr : weights.data(),
                        nullptr, static_cast<SCOTCH_Num>(neighbours.size()), neighbours.data(),
                        links.empty() ? nullptr : links.data()),
      "take the graph");
  check_scotch(SCOTCH_contextBindGraph(context.get(), plain.get(), bound.get()), "bind the graph");
  const auto count = static_cast<SCOTCH_Num>(part_count);
  check_scotch(SCOTCH_stratGraphMapBuild(strategy.get(), SCOTCH_STRATDEFAULT, count, imbalance), "build a strategy");
  check_scotch(SCOTCH_graphPart(bound.get(), count, strategy.get(), parts.data()), "partition the graph");
  std::ranges::transform(parts, targets.begin(), [](SCOTCH_Num p) { return static_cast<std::uint32_t>(p); });
}

}  // namespace tetloom

#pragma once
// Parts that are adapted by other ranks than those that have them, so that all ranks have about as much to do.
#include <cstdint>
#include <span>
#include <vector>

#include "adapt/parts/cut_parts.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// What a part will take, about.
struct PartLoad {
  double work = 0;  ///< to adapt it, microseconds
  double way = 0;   ///< to bring it to another rank and back, for each of the two
};

/// Where edges longer than `longest` are split. Reads one tet in a few. Pre: the part is started.
PartLoad load_of(const CavityMesh& part, double longest);

/// The rank that adapts each part. Parts stay where they are, in blocks as rank_of_part says, but that the rank of most
/// work gives one to that of least as long as this helps. The same on all ranks.
std::vector<int> lend_parts(std::span<const PartLoad> loads, int ranks);

/// A part that this rank adapts.
struct PartAtWork {
  PartOfWhole* part = nullptr;
  std::uint32_t number = 0;
  double work = 0;
};

/// Lends parts for a round. All functions in together.
class LentParts {
 public:
  /// `own`: the parts of this rank, of which `first` is the number of the first one; of `part_count` in all. `longest`:
  /// as of load_of.
  LentParts(std::span<PartOfWhole> own, std::uint32_t first, std::size_t part_count, double longest,
            const SharedWork& work);

  /// Sends what is lent; returns the parts that are here then, ascending in number.
  std::vector<PartAtWork> lend();
  /// Sends them back.
  void give_back();

 private:
  struct Borrowed {
    std::uint32_t number;
    PartOfWhole part;
  };
  std::size_t home_of(std::uint32_t part) const {
    return static_cast<std::size_t>(rank_of_part(part, loads_.size(), work_.rank_count()));
  }

  std::span<PartOfWhole> own_;
  std::uint32_t first_;
  const SharedWork& work_;
  std::vector<PartLoad> loads_;      // of all parts
  std::vector<int> to_rank_;         // of all parts: where they are adapted
  std::vector<std::uint32_t> lent_;  // of this rank's own, ascending
  std::vector<Borrowed> borrowed_;   // ascending
};

}  // namespace tetloom::adapt

#pragma once
// The links of one run, copied when it starts: what bodies do to their parts cannot change who is waited for.
#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "tetloom/assert.hpp"
#include "tetloom/communicator.hpp"

namespace tetloom::detail {

/// For each part of this rank an ascending list of parts.
class LinkTable {
 public:
  using ListOf = std::function<std::span<const PartId>(PartId)>;

  /// An empty function gives empty lists. Throws Error(Internal) when a list does not ascend or leaves the parts.
  LinkTable(std::span<const PartId> local, const ListOf& list_of, std::size_t part_count) {
    begins_.reserve(local.size() + 1);
    begins_.push_back(0);
    for (const PartId part : local) {
      if (list_of) append(list_of(part), part_count);
      begins_.push_back(parts_.size());
    }
  }

  std::span<const PartId> of(std::size_t local) const {
    return std::span(parts_).subspan(begins_[local], begins_[local + 1] - begins_[local]);
  }
  /// Where the list of `local` begins among all of them.
  std::size_t begin_of(std::size_t local) const { return begins_[local]; }
  std::size_t size() const { return parts_.size(); }

  static constexpr std::size_t kNotFound = ~std::size_t{0};
  /// The place of `part` in the list of `local`, or kNotFound.
  std::size_t find(std::size_t local, PartId part) const {
    const auto list = of(local);
    const auto place = std::lower_bound(list.begin(), list.end(), part);
    return place != list.end() && *place == part ? static_cast<std::size_t>(place - list.begin()) : kNotFound;
  }

 private:
  void append(std::span<const PartId> list, std::size_t part_count) {
    for (std::size_t i = 0; i < list.size(); ++i)
      TETLOOM_ASSERT(list[i].value < part_count && (i == 0 || list[i - 1] < list[i]));
    parts_.insert(parts_.end(), list.begin(), list.end());
  }

  std::vector<std::size_t> begins_;
  std::vector<PartId> parts_;
};

/// A number for one link; the sum over those of the receivers less that over those of the senders is 0 on all ranks
/// together when both sides agree.
inline std::uint64_t link_hash(std::size_t step, PartId from, PartId to) {
  std::uint64_t hash = step + 1;
  for (const std::uint64_t word : {from.value, to.value}) {
    hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 29;
  }
  return hash;
}

}  // namespace tetloom::detail

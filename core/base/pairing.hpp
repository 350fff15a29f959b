#pragma once
// Numbers of one side paired with numbers of the other, one to one.
#include <cstdint>
#include <map>

namespace tetloom {

/// Which number is whose partner, of numbers that are told in pairs.
class Pairing {
 public:
  /// Pairs two numbers; false where one of them has another partner.
  bool pair(std::uint64_t first, std::uint64_t second) {
    return to_second_.emplace(first, second).first->second == second &&
           to_first_.emplace(second, first).first->second == first;
  }

  /// The partner of every number of the first side.
  const std::map<std::uint64_t, std::uint64_t>& to_second() const { return to_second_; }

 private:
  std::map<std::uint64_t, std::uint64_t> to_second_, to_first_;
};

}  // namespace tetloom

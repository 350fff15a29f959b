#pragma once
// Disjoint sets over 0 … n-1. The representative of a set is its smallest member, so results do not depend on the
// order of the unions.
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace tetloom::detail {

class UnionFind {
 public:
  explicit UnionFind(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }

  std::uint32_t find(std::uint32_t a) {
    while (parent_[a] != a) a = parent_[a] = parent_[parent_[a]];
    return a;
  }
  void unite(std::uint32_t a, std::uint32_t b) {
    a = find(a), b = find(b);
    if (a > b) std::swap(a, b);
    parent_[b] = a;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace tetloom::detail

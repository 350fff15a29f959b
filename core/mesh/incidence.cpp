#include "core/mesh/incidence_detail.hpp"

namespace tetloom::detail {

std::vector<Window> cut_windows(std::span<const std::uint32_t> counts, std::size_t limit) {
  std::vector<Window> windows;
  Window open;
  for (std::uint32_t key = 0; key < counts.size(); ++key) {
    if (open.uses > 0 && open.uses + counts[key] > limit) {
      windows.push_back(open);
      open = {key, key, 0};
    }
    open.last = key + 1;
    open.uses += counts[key];
  }
  if (open.uses > 0) windows.push_back(open);
  return windows;
}

}  // namespace tetloom::detail

#include "tetloom/host.hpp"

#include <algorithm>

namespace tetloom {
namespace {

class SerialLoop : public BlockLoop {
 public:
  void for_blocks(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) const override {
    for (std::size_t begin = 0; begin < count; begin += grain) body(begin, std::min(count, begin + grain));
  }
};

}  // namespace

const BlockLoop& serial_loop() {
  static const SerialLoop loop;
  return loop;
}

}  // namespace tetloom

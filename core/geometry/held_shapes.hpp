#pragma once
// Shapes that were read and are kept for the next who asks, up to some bytes.
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>

namespace tetloom {

/// Keeps those that were used last. Thread safety: any number of threads; a shape may be made by two of them at once.
class HeldShapes {
 public:
  struct Shape {
    std::shared_ptr<const void> value;
    std::uint64_t bytes = 0;
  };

  /// One shape is kept even where it has more than `most_bytes`.
  explicit HeldShapes(std::uint64_t most_bytes) : most_bytes_(most_bytes) {}

  /// The shape of a number, as `make` has made it now or before. What that throws reaches the caller.
  template <class Value>
  std::shared_ptr<const Value> get(std::size_t number, const std::function<Shape()>& make) {
    return std::static_pointer_cast<const Value>(get_any(number, make));
  }

  /// The most that was held at once so far.
  std::uint64_t peak_bytes() const;

 private:
  struct Held {
    std::size_t number;
    Shape shape;
  };
  std::shared_ptr<const void> get_any(std::size_t number, const std::function<Shape()>& make);

  const std::uint64_t most_bytes_;
  mutable std::mutex mutex_;  // around all below
  std::uint64_t bytes_ = 0, peak_bytes_ = 0;
  std::list<Held> held_;  // the one that was used last in front
  std::unordered_map<std::size_t, std::list<Held>::iterator> by_number_;
};

}  // namespace tetloom

#pragma once
// What goes over the wire: frames of whole messages, or one that announces a large message, which follows in pieces.
#include <cstdint>
#include <vector>

#include "tetloom/communicator.hpp"

namespace tetloom::detail {

enum class RankFrameKind : std::uint64_t { Messages, Large, Failure };

/// `epoch` numbers the runs, so that what a faster rank sends for the next run is not taken for this one.
struct FrameHead {
  std::uint64_t epoch;
  RankFrameKind kind;
};

inline void put_address(MessageWriter& writer, const Message& message) {
  writer.put(message.from);
  writer.put(message.to);
  writer.put(message.step);
}

inline Message get_address(MessageReader& reader) {
  Message message;
  message.from = reader.get<PartId>();
  message.to = reader.get<PartId>();
  message.step = reader.get<std::uint32_t>();
  return message;
}

inline Bytes failure_frame(std::uint64_t epoch) {
  MessageWriter writer;
  writer.put(FrameHead{epoch, RankFrameKind::Failure});
  return writer.take();
}

inline Bytes large_frame(std::uint64_t epoch, const Message& message) {
  MessageWriter writer;
  writer.put(FrameHead{epoch, RankFrameKind::Large});
  put_address(writer, message);
  writer.put(static_cast<std::uint64_t>(message.bytes.size()));
  return writer.take();
}

/// Collects small messages into one frame.
class FramePacker {
 public:
  explicit FramePacker(std::uint64_t epoch) : epoch_(epoch) {}
  std::size_t size() const { return size_; }

  void add(const Message& message) {
    if (size_ == 0) writer_.put(FrameHead{epoch_, RankFrameKind::Messages});
    put_address(writer_, message);
    writer_.put_array(std::span<const std::byte>(message.bytes));
    size_ += kAddressSize + message.bytes.size();
  }
  Bytes take() {
    size_ = 0;
    return writer_.take();
  }

 private:
  static constexpr std::size_t kAddressSize = 20;
  std::uint64_t epoch_;
  MessageWriter writer_;
  std::size_t size_ = 0;
};

/// A large message of which pieces are still to come, in order.
struct PartialMessage {
  Message message;
  std::uint64_t epoch = 0;
  std::size_t arrived = 0;

  bool incomplete() const { return arrived < message.bytes.size(); }
};

}  // namespace tetloom::detail

#pragma once
// The form in which cells travel from one part to another.
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/base/local_numbers.hpp"
#include "tetloom/partition.hpp"

namespace tetloom::detail {

/// Makes packets of cells of one part. What is needed of the part beside its arrays is computed once; packets can then
/// be made side by side, each lane with a scratch of its own.
class CellPacker {
 public:
  /// `part` must outlive the packer; its adjacency is not needed.
  explicit CellPacker(const Part& part);

  /// Working memory, for any number of packets one after the other.
  struct Scratch {
    LocalNumbers verts;     ///< of the part, in the packet
    LocalNumbers elements;  ///< of the boundary, counted over its kinds
  };
  /// Puts a packet behind what `writer` has already. Pre: `cells` ascends; cells of all kinds are numbered one after
  /// the other. `verts` (may be null) gets the part's vertices in the order in which the packet has them.
  void pack(std::span<const std::uint32_t> cells, Scratch& scratch, MessageWriter& writer,
            std::vector<std::uint32_t>* verts = nullptr) const;

 private:
  struct BoundaryIndex;
  class PacketWriter;

  const Part& part_;
  std::shared_ptr<const BoundaryIndex> index_;
  std::vector<bool> shared_;  // vertices on the part boundary
};

/// A model entity, as packets hold it.
void put_entity(MessageWriter& writer, const PartEntity& entity);
PartEntity get_entity(MessageReader& reader);

/// All cells of a part by destination.
struct SortedCells {
  std::vector<PartId> receivers;     ///< the parts that get something, ascending
  std::vector<std::uint32_t> first;  ///< of the cells of each in `cells`; one longer
  std::vector<std::uint32_t> cells;  ///< ascending for each
  std::span<const std::uint32_t> of(std::size_t k) const {
    return std::span(cells).subspan(first[k], first[k + 1] - first[k]);
  }
};

/// Throws Error(InvalidArgument) for a destination that is not below `part_count`.
SortedCells sort_by_destination(const Destinations& destinations, std::size_t part_count);

/// Makes a part of packets, which must be ascending by sender; frees each once it has been read. The fields are those
/// of `mesh`.
PartMesh unpack_part(std::span<Message> packets, const PartitionedMesh& mesh);

/// The same, where nothing is connected yet.
PartMesh merge_packets(std::span<Message> packets, const PartitionedMesh& mesh);

/// The same of `count` packets that `next` gives, one after the other.
PartMesh merge_packets(std::size_t count, const std::function<Bytes(std::size_t)>& next, const PartitionedMesh& mesh);

/// What a packet has become in the part that it was added to.
struct AddedPacket {
  PartId sender;
  std::array<std::size_t, kCellKinds> cells;  ///< how many of each kind
  std::span<const std::uint32_t> verts;       ///< the part's numbers of the packet's vertices
  MessageReader& rest;                        ///< what the message holds behind the packet
};

/// `part` with the cells of the packets that `messages` begin with added behind its own, whose numbers stay. Vertices
/// and boundary elements that it has on its part boundary, or gets from several senders, are there once. Nothing is
/// connected yet. `visit` sees each packet once it is in; then its message is freed.
PartMesh extend_part(Part&& part, std::span<Message> messages, const PartitionedMesh& mesh,
                     const std::function<void(const AddedPacket&)>& visit);

}  // namespace tetloom::detail

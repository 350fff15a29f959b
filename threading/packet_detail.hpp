#pragma once
// The form in which cells travel from one part to another.
#include <cstdint>
#include <memory>
#include <vector>

#include "threading/migration.hpp"

namespace tetloom::detail {

/// Makes the packets of one part. What is needed of the part beside its arrays is computed once and read by the
/// packers of all destinations, which may run side by side.
class PartPacker {
 public:
  PartPacker(const Part& part, const Destinations& destinations, std::size_t part_count);

  /// The parts that get something, ascending.
  const std::vector<PartId>& receivers() const { return receivers_; }
  /// The number of cells for receivers()[k].
  std::size_t cell_count(std::size_t k) const { return first_[k + 1] - first_[k]; }
  /// Working memory of a packer, for any number of packets one after the other.
  struct Scratch {
    std::vector<std::uint32_t> local;     ///< number in the packet of a vertex of the part
    std::vector<std::uint32_t> verts;     ///< those numbered, in order
    std::vector<bool> taken;              ///< boundary elements in the packet
    std::vector<std::uint32_t> boundary;  ///< those, by kind
  };
  Bytes pack(std::size_t k, Scratch& scratch) const;

 private:
  struct BoundaryIndex;
  class PacketWriter;

  void sort_by_destination(const Destinations& destinations, std::size_t part_count);

  const Part& part_;
  std::vector<PartId> receivers_;
  std::vector<std::uint32_t> first_;  // of the cells of each receiver in order_
  std::vector<std::uint32_t> order_;  // all cells, by receiver
  std::shared_ptr<const BoundaryIndex> index_;
  std::vector<bool> shared_;  // vertices on the part boundary
};

/// Makes a part of packets, which must be ascending by sender; frees each once it has been read. The fields are those
/// of `mesh`.
PartMesh unpack_part(std::vector<Message>& packets, const PartitionedMesh& mesh);

}  // namespace tetloom::detail

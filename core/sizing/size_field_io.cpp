// The flat form of a size field: a header, the cells, the corner ratios; native byte order, since it only travels
// between processes of one machine.
#include <cstring>
#include <string>

#include "core/sizing/size_tree.hpp"
#include "tetloom/error.hpp"

namespace tetloom {
namespace {

struct FlatHeader {
  std::uint64_t magic = kMagic;
  std::uint64_t cell_count = 0;   ///< 0: a uniform field
  std::uint64_t ratio_count = 0;  ///< blocks of 8 floats
  double size = 0, gradation = 0, width = 0;
  Vec3 origin, domain_lo, domain_hi;

  static constexpr std::uint64_t kMagic = 0x315a53204d4f4f4cULL;  // "LOOM SZ1"
};

constexpr std::size_t kCellBytes = sizeof(std::uint32_t), kRatioBytes = sizeof(std::array<float, 8>);

[[noreturn]] void refuse(const std::string& why) {
  throw Error(ErrorCode::InputUnreadable, "not a size field: " + why);
}

/// Copies `count` values to `offset` and returns the end of the copy.
template <class T>
std::size_t put(std::vector<std::byte>& out, std::size_t offset, const T* data, std::size_t count) {
  if (count > 0) std::memcpy(out.data() + offset, data, count * sizeof(T));
  return offset + count * sizeof(T);
}

/// Pre: count * sizeof(T) bytes are there.
template <class T>
std::vector<T> take(std::span<const std::byte>& bytes, std::size_t count) {
  std::vector<T> values(count);
  if (count > 0) std::memcpy(values.data(), bytes.data(), count * sizeof(T));
  bytes = bytes.subspan(count * sizeof(T));
  return values;
}

}  // namespace

std::vector<std::byte> SizeField::serialize() const {
  FlatHeader header;
  header.size = largest_;
  if (!tree_) {
    std::vector<std::byte> out(sizeof header);
    put(out, 0, &header, 1);
    return out;
  }
  const SizeOctree& octree = tree_->octree();
  header.cell_count = octree.cells.size();
  header.ratio_count = octree.corner_ratios.size();
  header.gradation = octree.gradation;
  header.width = octree.width;
  header.origin = octree.origin;
  header.domain_lo = octree.domain.lo;
  header.domain_hi = octree.domain.hi;
  std::vector<std::byte> out(sizeof header + header.cell_count * kCellBytes + header.ratio_count * kRatioBytes);
  std::size_t end = put(out, 0, &header, 1);
  end = put(out, end, octree.cells.data(), octree.cells.size());
  put(out, end, octree.corner_ratios.data(), octree.corner_ratios.size());
  return out;
}

SizeField SizeField::deserialize(std::span<const std::byte> bytes) {
  if (bytes.size() < sizeof(FlatHeader)) refuse("it is shorter than its header");
  FlatHeader header;
  std::memcpy(&header, bytes.data(), sizeof header);
  bytes = bytes.subspan(sizeof header);
  if (header.magic != FlatHeader::kMagic) refuse("it does not begin with the mark of one");
  if (header.cell_count > bytes.size() / kCellBytes || header.ratio_count > bytes.size() / kRatioBytes ||
      header.cell_count * kCellBytes + header.ratio_count * kRatioBytes != bytes.size())
    refuse("its length is not what its header says");
  try {
    if (header.cell_count == 0) {
      if (header.ratio_count != 0) refuse("it has ratios but no cells");
      return uniform(header.size);
    }
    SizeOctree octree;
    octree.size = header.size;
    octree.gradation = header.gradation;
    octree.width = header.width;
    octree.origin = header.origin;
    octree.domain = {header.domain_lo, header.domain_hi};
    octree.cells = take<std::uint32_t>(bytes, header.cell_count);
    octree.corner_ratios = take<std::array<float, 8>>(bytes, header.ratio_count);
    return from_octree(std::move(octree));
  } catch (const Error& error) {
    if (error.code() == ErrorCode::InvalidArgument) refuse(error.what());
    throw;
  }
}

}  // namespace tetloom

// Links and attributes of objects that have many: a B-tree of version 2 with ids of objects in a fractal heap.
#include <algorithm>
#include <array>
#include <bit>

#include "core/io/hdf5/hdf5_objects_detail.hpp"

namespace tetloom::detail {
namespace {

constexpr std::uint64_t kTreeHeaderBytes = 38, kNodePrefix = 6, kChecksumBytes = 4, kHeapHeaderBytes = 146;

std::uint64_t little_endian(std::string_view bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = std::min<std::size_t>(bytes.size(), 8); i-- > 0;)
    value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

// How many bytes a number up to `most` takes.
std::uint64_t bytes_for(std::uint64_t most) {
  return (static_cast<std::uint64_t>(std::bit_width(std::max<std::uint64_t>(most, 1))) - 1) / 8 + 1;
}

class RecordTree {
 public:
  RecordTree(Hdf5Objects& objects, std::uint64_t address, std::size_t id_offset,
             const std::function<void(std::string_view)>& visit)
      : objects_(objects), id_offset_(id_offset), visit_(visit) {
    const std::string_view header = objects.metadata(address, kTreeHeaderBytes);
    if (!header.starts_with("BTHD")) objects.fail(header, "no B-tree of version 2");
    node_bytes_ = little_endian(header.substr(6, 4));
    record_bytes_ = little_endian(header.substr(10, 2));
    const std::uint64_t depth = little_endian(header.substr(12, 2));
    const std::uint64_t root = little_endian(header.substr(16, 8)), records = little_endian(header.substr(24, 2));
    const bool fine = record_bytes_ > id_offset && node_bytes_ > kNodePrefix + kChecksumBytes + record_bytes_ &&
                      depth < kHdf5MostLevels;
    if (!fine) objects.fail(header, "a damaged B-tree");
    find_widths(depth);
    if (root != kHdf5NoAddress) visit_node(root, records, depth);
  }

 private:
  // Of the numbers that count the records below a child.
  void find_widths(std::uint64_t depth) {
    const std::uint64_t room = node_bytes_ - kNodePrefix - kChecksumBytes;
    const std::uint64_t leaf_most = room / record_bytes_;
    count_bytes_ = bytes_for(leaf_most);
    total_bytes_.assign(1, 0);
    std::uint64_t total = leaf_most;
    for (std::uint64_t level = 1; level <= depth; ++level) {
      const std::uint64_t pointer = 8 + count_bytes_ + total_bytes_.back();
      const std::uint64_t most = room < pointer ? 0 : (room - pointer) / (record_bytes_ + pointer);
      const bool overflows = total > (kHdf5NoAddress - most) / (most + 1);
      total = overflows ? kHdf5NoAddress : (most + 1) * total + most;
      total_bytes_.push_back(bytes_for(total));
    }
  }

  void visit_node(std::uint64_t address, std::uint64_t records, std::uint64_t level) {
    const std::uint64_t pointer = level == 0 ? 0 : 8 + count_bytes_ + total_bytes_[level - 1];
    const std::uint64_t size = kNodePrefix + records * record_bytes_ + (level == 0 ? 0 : (records + 1) * pointer);
    const std::string_view node = objects_.metadata(address, size);
    if (!node.starts_with(level == 0 ? "BTLF" : "BTIN")) objects_.fail(node, "a damaged node of a B-tree");
    for (std::uint64_t i = 0; i < records; ++i)
      visit_(node.substr(kNodePrefix + i * record_bytes_ + id_offset_, record_bytes_ - id_offset_));
    if (level == 0) return;
    std::string_view children = node.substr(kNodePrefix + records * record_bytes_);
    for (std::uint64_t i = 0; i <= records; ++i, children.remove_prefix(pointer))
      visit_node(little_endian(children.substr(0, 8)), little_endian(children.substr(8, count_bytes_)), level - 1);
  }

  Hdf5Objects& objects_;
  std::size_t id_offset_;
  const std::function<void(std::string_view)>& visit_;
  std::uint64_t node_bytes_ = 0, record_bytes_ = 0, count_bytes_ = 0;
  std::vector<std::uint64_t> total_bytes_;
};

}  // namespace

void visit_hdf5_records(Hdf5Objects& objects, std::uint64_t tree, std::size_t id_offset,
                        const std::function<void(std::string_view)>& visit) {
  RecordTree(objects, tree, id_offset, visit);
}

Hdf5Heap::Hdf5Heap(Hdf5Objects& objects, std::uint64_t address)
    : objects_(objects), header_(objects.metadata(address, kHeapHeaderBytes)) {
  if (!header_.starts_with("FRHP")) objects.fail(header_, "no fractal heap");
  id_bytes_ = static_cast<unsigned>(little_endian(header_.substr(5, 2)));
  const std::uint64_t filters = little_endian(header_.substr(7, 2));
  width_ = static_cast<unsigned>(little_endian(header_.substr(110, 2)));
  start_bytes_ = little_endian(header_.substr(112, 8));
  most_direct_ = little_endian(header_.substr(120, 8));
  const std::uint64_t bits = little_endian(header_.substr(128, 2));
  offset_bytes_ = static_cast<unsigned>((bits + 7) / 8);
  root_ = little_endian(header_.substr(132, 8));
  rows_ = static_cast<unsigned>(little_endian(header_.substr(140, 2)));
  const bool fine = bits <= 64 && offset_bytes_ + 1 < id_bytes_ && width_ > 0 && std::has_single_bit(width_) &&
                    std::has_single_bit(start_bytes_) && start_bytes_ < (std::uint64_t{1} << 32) &&
                    most_direct_ >= start_bytes_ && most_direct_ < (std::uint64_t{1} << 32) && rows_ < 64;
  if (!fine || filters != 0) objects.fail(header_, "a fractal heap that is damaged or compressed");
}

std::string_view Hdf5Heap::object(std::string_view id) {
  constexpr unsigned kManaged = 0;
  if (id.size() < id_bytes_) objects_.fail(id, "an id that is too short for its heap");
  if (static_cast<unsigned char>(id[0]) >> 4 != kManaged)
    objects_.fail(id, "an object outside of the blocks of its heap");
  const std::uint64_t offset = little_endian(id.substr(1, offset_bytes_));
  const std::uint64_t size = little_endian(id.substr(1 + offset_bytes_, id_bytes_ - 1 - offset_bytes_));
  if (rows_ > 0) return find(root_, rows_, offset, size, 0);
  if (offset > start_bytes_ || size > start_bytes_ - offset) objects_.fail(id, "an id beyond its heap");
  return objects_.metadata(root_ + offset, size);
}

// Of `rows` rows of blocks; those of a row have the same size, which doubles from the third one on.
std::string_view Hdf5Heap::find(std::uint64_t block, unsigned rows, std::uint64_t offset, std::uint64_t size,
                                int level) {
  const std::uint64_t prefix = 13 + offset_bytes_;
  std::uint64_t begin = 0;
  for (unsigned row = 0; row < rows && level < kHdf5MostLevels; begin += width_ * row_bytes(row), ++row) {
    const std::uint64_t bytes = row_bytes(row);
    if (bytes > (std::uint64_t{1} << 40) || offset < begin) break;
    if (offset - begin >= width_ * bytes) continue;
    const std::uint64_t column = (offset - begin) / bytes, inside = (offset - begin) % bytes;
    const std::string_view head = objects_.metadata(block, 4);
    if (!head.starts_with("FHIB")) objects_.fail(head, "a damaged block of a fractal heap");
    const std::uint64_t child = little_endian(objects_.metadata(block + prefix + 8 * (row * width_ + column), 8));
    if (bytes > most_direct_) {
      const auto child_rows = std::bit_width(bytes) - std::bit_width(start_bytes_ * width_) + 1;
      return find(child, child_rows > 0 ? static_cast<unsigned>(child_rows) : 0, inside, size, level + 1);
    }
    if (size > bytes - inside) break;
    return objects_.metadata(child + inside, size);
  }
  objects_.fail(header_, "an id beyond its heap");
}

}  // namespace tetloom::detail

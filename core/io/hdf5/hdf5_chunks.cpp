#include "core/io/hdf5/hdf5_chunks_detail.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstring>

namespace tetloom::detail {
namespace {

constexpr std::uint64_t kMostInflation = 1032;  // of deflate
constexpr std::uint16_t kDeflate = 1, kShuffle = 2, kFletcher = 3;
constexpr std::size_t kFletcherBytes = 4;

struct StoredChunk {
  std::uint32_t skipped;  // filters, as bits
  std::vector<std::uint64_t> begin;
  std::string_view stored;
};

class ChunkReader {
 public:
  ChunkReader(Hdf5Objects& objects, const Hdf5Array& array, std::span<const std::uint64_t> shape, std::uint64_t bytes)
      : objects_(objects), array_(array), shape_(shape), bytes_(bytes) {}

  std::string read() {
    const bool fits = array_.chunk_shape.size() == shape_.size() + 1 && !shape_.empty();
    if (!fits || std::ranges::find(array_.chunk_shape, 0u) != array_.chunk_shape.end())
      fail("chunks that do not fit an array");
    for (const std::uint32_t extent : array_.chunk_shape) {
      if (chunk_bytes_ > most_bytes() / extent) fail("chunks that exceed the file");
      chunk_bytes_ *= extent;
    }
    std::uint64_t most_chunks = 1;
    for (std::size_t d = 0; d < shape_.size(); ++d)
      most_chunks *=
          std::min<std::uint64_t>(shape_[d] / array_.chunk_shape[d] + 1, std::uint64_t{1} << 62 / shape_.size());
    if (array_.chunk_index != kHdf5NoAddress) find_chunks(array_.chunk_index, 0);
    if (chunks_.size() > most_chunks) fail("more chunks than an array has");
    std::uint64_t stored = 0;
    for (const StoredChunk& chunk : chunks_) stored += chunk.stored.size();
    stored = std::min<std::uint64_t>(stored, objects_.file().bytes().size());
    if (bytes_ > stored * kMostInflation) fail("an array that exceeds its chunks");
    std::string out(bytes_, '\0');
    for (const StoredChunk& chunk : chunks_) place(chunk, unpacked(chunk), out);
    return out;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { objects_.file().fail(ErrorCode::InputUnreadable, what); }
  std::uint64_t most_bytes() const { return kMostInflation * objects_.file().bytes().size(); }
  std::size_t element_bytes() const { return array_.chunk_shape.back(); }

  void find_chunks(std::uint64_t address, int level) {
    if (level > kHdf5MostLevels) fail("a B-tree of chunks that is too deep");
    Cursor head(objects_.file(), objects_.metadata(address, 24));
    if (head.read<std::uint32_t>() != 0x45455254) fail("a damaged B-tree of chunks");  // "TREE"
    head.read<std::uint8_t>();
    const bool is_leaf = head.read<std::uint8_t>() == 0;
    const std::uint64_t count = head.read<std::uint16_t>(), rank = array_.chunk_shape.size();
    Cursor cursor(objects_.file(), objects_.metadata(address + 24, count * (16 + 8 * rank)));
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::uint64_t size = cursor.read<std::uint32_t>();
      StoredChunk chunk{cursor.read<std::uint32_t>(), {}, {}};
      for (std::uint64_t d = 0; d < rank; ++d) chunk.begin.push_back(cursor.read<std::uint64_t>());
      const auto child = cursor.read<std::uint64_t>();
      if (!is_leaf) {
        find_chunks(child, level + 1);
        continue;
      }
      chunk.stored = objects_.data(child, size);
      chunks_.push_back(std::move(chunk));
    }
  }

  // Filters were applied in their order, so they are undone from the last to the first.
  std::string unpacked(const StoredChunk& chunk) const {
    objects_.file().check_cancelled();
    std::string bytes(chunk.stored);
    for (std::size_t i = array_.filters.size(); i-- > 0;) {
      if (i < 32 && (chunk.skipped >> i & 1u) != 0) continue;
      switch (array_.filters[i].id) {
        case kDeflate: bytes = inflated(bytes); break;
        case kShuffle: bytes = unshuffled(bytes); break;
        case kFletcher: bytes.resize(bytes.size() - std::min(bytes.size(), kFletcherBytes)); break;
        default:
          objects_.file().fail(ErrorCode::InputUnsuitable,
                               "an array is packed by the filter " + std::to_string(array_.filters[i].id) +
                                   " of HDF5; of filters, deflate, shuffle and fletcher32 are known");
      }
    }
    if (bytes.size() != chunk_bytes_) fail("a damaged chunk of an array");
    return bytes;
  }

  std::string inflated(const std::string& packed) const {
    // A checksum may be part of what was packed.
    const std::uint64_t most = chunk_bytes_ + kFletcherBytes;
    if (chunk_bytes_ > packed.size() * kMostInflation) fail("a chunk that exceeds its bytes");
    std::string bytes(most, '\0');
    uLongf size = most;
    const int status = ::uncompress(reinterpret_cast<Bytef*>(bytes.data()), &size,
                                    reinterpret_cast<const Bytef*>(packed.data()), packed.size());
    if (status != Z_OK) fail("a chunk that cannot be unpacked");
    bytes.resize(size);
    return bytes;
  }

  std::string unshuffled(const std::string& bytes) const {
    const std::size_t width = element_bytes(), count = bytes.size() / width;
    std::string out = bytes;
    for (std::size_t byte = 0; byte < width; ++byte)
      for (std::size_t i = 0; i < count; ++i) out[i * width + byte] = bytes[byte * count + i];
    return out;
  }

  // Row by row, a row being all along the last dimension; chunks reach over the end of the array.
  void place(const StoredChunk& chunk, const std::string& bytes, std::string& out) const {
    const std::size_t rank = shape_.size(), width = element_bytes();
    const std::uint64_t row = array_.chunk_shape[rank - 1], rows = chunk_bytes_ / width / row;
    for (std::uint64_t r = 0; r < rows; ++r) {
      std::uint64_t at = 0, rest = r, stride = shape_[rank - 1];
      bool inside = chunk.begin[rank - 1] < shape_[rank - 1];
      for (std::size_t d = rank - 1; d-- > 0;) {
        const std::uint64_t local = rest % array_.chunk_shape[d];
        rest /= array_.chunk_shape[d];
        inside = inside && chunk.begin[d] < shape_[d] && local < shape_[d] - chunk.begin[d];
        if (!inside) break;
        at += (chunk.begin[d] + local) * stride;
        stride *= shape_[d];
      }
      if (!inside) continue;
      const std::uint64_t first = chunk.begin[rank - 1], count = std::min(row, shape_[rank - 1] - first);
      std::memcpy(out.data() + (at + first) * width, bytes.data() + r * row * width, count * width);
    }
  }

  Hdf5Objects& objects_;
  const Hdf5Array& array_;
  std::span<const std::uint64_t> shape_;
  std::uint64_t bytes_, chunk_bytes_ = 1;
  std::vector<StoredChunk> chunks_;
};

}  // namespace

std::string read_hdf5_chunks(Hdf5Objects& objects, const Hdf5Array& array, std::span<const std::uint64_t> shape,
                             std::uint64_t bytes) {
  return ChunkReader(objects, array, shape, bytes).read();
}

}  // namespace tetloom::detail

#pragma once
// Private to core/io: the objects of an HDF5 file in memory. Every address and every length is checked against the file
// before it is used, and all metadata together cost at most a fixed multiple of the size of the file, so that damaged
// files give errors.
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/hdf5/hdf5_detail.hpp"
#include "core/io/input_detail.hpp"

namespace tetloom::detail {

/// Of the elements of a dataset or an attribute.
struct Hdf5Datatype {
  Hdf5Class kind = Hdf5Class::Other;
  std::uint32_t bytes = 0;
  bool is_signed = false;
  bool is_big_endian = false;
};

/// None: the space holds nothing.
using Hdf5Shape = std::optional<std::vector<std::uint64_t>>;

/// An attribute as it lies in the file.
struct Hdf5AttributeValue {
  Hdf5Datatype type;
  Hdf5Shape shape;
  std::string_view data;  ///< at most what the file has of it
};

/// What the chunks of a dataset went through.
struct Hdf5Filter {
  std::uint16_t id;
  bool is_optional;
};

/// A dataset as it lies in the file.
struct Hdf5Array {
  enum class Layout { None, Compact, Contiguous, Chunked, Other };
  Layout layout = Layout::None;
  std::string_view data;                   ///< of a compact or contiguous one
  std::uint64_t chunk_index = 0;           ///< the address of a B-tree
  std::vector<std::uint32_t> chunk_shape;  ///< the last number is the size of an element
  std::vector<Hdf5Filter> filters;
  bool is_external = false;
};

/// A group or a dataset.
struct Hdf5Object {
  struct Member {
    std::uint64_t address = 0;
    std::uint64_t order = 0;  ///< of creation, or 0 where that is not known
  };
  std::map<std::string, Member, std::less<>> members;  ///< by hard links; others are passed over
  std::map<std::string, Hdf5AttributeValue, std::less<>> attributes;
  std::optional<Hdf5Datatype> type;
  Hdf5Shape shape;
  Hdf5Array array;
};

/// The objects of an HDF5 file, by address.
class Hdf5Objects {
 public:
  /// Throws Error(InputUnreadable) where the file is no HDF5 file, Error(InputUnsuitable) for user blocks and numbers
  /// of other than 8 bytes.
  explicit Hdf5Objects(const InputFile& file);

  const InputFile& file() const { return file_; }
  std::uint64_t root() const { return root_; }
  /// The object with a header at `address`. References live as long as this.
  const Hdf5Object& at(std::uint64_t address);
  /// `size` bytes at `address`. Throws where they are not in the file, and once too many have been asked for.
  std::string_view metadata(std::uint64_t address, std::uint64_t size);
  /// What the file has from `address` on, at most `size` bytes.
  std::string_view data(std::uint64_t address, std::uint64_t size) const;
  [[noreturn]] void fail(std::string_view where, const std::string& what) const { file_.fail(what, where.data()); }

 private:
  struct Block {
    std::uint64_t address, size;
  };
  using Visit = std::function<void(std::string_view)>;

  Hdf5Object parse(std::uint64_t address);
  void parse_old_messages(Hdf5Object& object, std::string_view bytes, std::vector<Block>& more);
  void parse_new_messages(Hdf5Object& object, std::string_view bytes, bool have_order, std::vector<Block>& more);
  void parse_message(Hdf5Object& object, unsigned type, unsigned flags, std::string_view body,
                     std::vector<Block>& more);
  void add_link(Hdf5Object& object, std::string_view body) const;
  void add_attribute(Hdf5Object& object, std::string_view body) const;
  void add_symbols(Hdf5Object& object, std::uint64_t tree, std::string_view names, int level);
  void add_filters(Hdf5Object& object, std::string_view body) const;
  void set_layout(Hdf5Object& object, std::string_view body) const;
  void add_dense_links(Hdf5Object& object, std::string_view body);
  void add_dense_attributes(Hdf5Object& object, std::string_view body);
  void visit_dense(std::uint64_t heap, std::uint64_t tree, std::size_t id_offset, const Visit& visit);

  const InputFile& file_;
  std::uint64_t root_ = 0;
  std::uint64_t budget_;  // of bytes of metadata
  std::map<std::uint64_t, Hdf5Object> known_;
};

/// Calls visit(id) for the heap ids in the records of a B-tree of version 2; each starts `id_offset` bytes into its
/// record.
void visit_hdf5_records(Hdf5Objects& objects, std::uint64_t tree, std::size_t id_offset,
                        const std::function<void(std::string_view)>& visit);

/// A fractal heap, of which objects that lie in its blocks are read.
class Hdf5Heap {
 public:
  Hdf5Heap(Hdf5Objects& objects, std::uint64_t address);
  /// The object with an id, which may be longer than ids of this heap.
  std::string_view object(std::string_view id);

 private:
  std::uint64_t row_bytes(unsigned row) const { return row < 2 ? start_bytes_ : start_bytes_ << (row - 1); }
  std::string_view find(std::uint64_t block, unsigned rows, std::uint64_t offset, std::uint64_t size, int level);

  Hdf5Objects& objects_;
  std::string_view header_;
  unsigned id_bytes_, offset_bytes_, width_, rows_;
  std::uint64_t start_bytes_, most_direct_, root_;
};

}  // namespace tetloom::detail

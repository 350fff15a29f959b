#include "core/io/hdf5/hdf5_objects_detail.hpp"

#include <algorithm>

namespace tetloom::detail {
namespace {

constexpr std::uint64_t kBudgetPerByte = 64, kLeastBudget = 1 << 20;
constexpr std::size_t kMostDimensions = 32;

std::size_t padded(std::size_t size) { return (size + 7) / 8 * 8; }

std::string_view take(Cursor& cursor, std::size_t size) {
  cursor.expect(size, 1);
  const std::string_view bytes = cursor.rest().substr(0, size);
  cursor.jump(cursor.at() + size);
  return bytes;
}

std::uint64_t read_number(Cursor& cursor, unsigned bytes) {
  switch (bytes) {
    case 1: return cursor.read<std::uint8_t>();
    case 2: return cursor.read<std::uint16_t>();
    case 4: return cursor.read<std::uint32_t>();
    default: return cursor.read<std::uint64_t>();
  }
}

Hdf5Datatype parse_datatype(const InputFile& file, std::string_view body) {
  constexpr unsigned kSigned = 0x08, kBigEndian = 0x01, kVax = 0x40, kArray = 10;
  Cursor cursor(file, body);
  const unsigned head = cursor.read<std::uint8_t>(), kind = head & 0x0fu, version = head >> 4,
                 bits = cursor.read<std::uint8_t>();
  take(cursor, 2);
  Hdf5Datatype type;
  type.bytes = cursor.read<std::uint32_t>();
  type.is_signed = (bits & kSigned) != 0;
  type.is_big_endian = (bits & kBigEndian) != 0;
  if (kind == kArray) {  // fixed fields of characters, as MED has them
    const unsigned rank = cursor.read<std::uint8_t>();
    take(cursor, version == 2 ? 3 + 8 * rank : 4 * rank);
    const Hdf5Datatype base = parse_datatype(file, cursor.rest());
    if (base.kind == Hdf5Class::Integer && base.bytes == 1) type.kind = Hdf5Class::String;
    return type;
  }
  const bool is_text = kind == static_cast<unsigned>(Hdf5Class::String);
  const bool is_number = kind <= static_cast<unsigned>(Hdf5Class::Real) && (kind == 0 || (bits & kVax) == 0);
  if (!is_text && !is_number) return type;
  if (is_number) {  // all bits of all bytes
    const std::uint16_t offset = cursor.read<std::uint16_t>(), precision = cursor.read<std::uint16_t>();
    if (offset != 0 || precision != 8 * std::uint64_t{type.bytes}) return type;
  }
  type.kind = static_cast<Hdf5Class>(kind);
  return type;
}

Hdf5Shape parse_dataspace(const InputFile& file, std::string_view body) {
  constexpr unsigned kNull = 2;
  Cursor cursor(file, body);
  const unsigned version = cursor.read<std::uint8_t>();
  const std::size_t rank = cursor.read<std::uint8_t>();
  take(cursor, 1);
  const unsigned type = cursor.read<std::uint8_t>();
  if (version == 2 && type == kNull) return {};
  if (version == 1) take(cursor, 4);
  if (version < 1 || version > 2 || rank > kMostDimensions) file.fail("a dataspace of an unknown form", body.data());
  std::vector<std::uint64_t> shape;
  for (std::size_t i = 0; i < rank; ++i) shape.push_back(cursor.read<std::uint64_t>());
  return shape;
}

}  // namespace

Hdf5Objects::Hdf5Objects(const InputFile& file)
    : file_(file), budget_(kLeastBudget + kBudgetPerByte * file.bytes().size()) {
  if (!file.bytes().starts_with(kHdf5Signature)) file.fail("this is no HDF5 file", file.bytes().data());
  Cursor cursor(file, file.bytes().substr(kHdf5Signature.size()));
  const unsigned version = cursor.read<std::uint8_t>();
  if (version > 3) file.fail("a superblock of an unknown version", cursor.at());
  const bool is_old = version < 2;
  if (is_old) take(cursor, 4);
  const unsigned address_bytes = cursor.read<std::uint8_t>(), length_bytes = cursor.read<std::uint8_t>();
  if (address_bytes != 8 || length_bytes != 8)
    file.fail(ErrorCode::InputUnsuitable, "the addresses of this HDF5 file do not have 8 bytes");
  take(cursor, version == 0 ? 9 : version == 1 ? 13 : 1);
  if (cursor.read<std::uint64_t>() != 0)
    file.fail(ErrorCode::InputUnsuitable, "this HDF5 file is embedded in another one");
  take(cursor, is_old ? 32 : 16);
  root_ = cursor.read<std::uint64_t>();
}

std::string_view Hdf5Objects::metadata(std::uint64_t address, std::uint64_t size) {
  const std::string_view bytes = file_.bytes();
  if (address > bytes.size() || size > bytes.size() - address)
    file_.fail(ErrorCode::InputUnreadable, "an address leads out of the file");
  if (size + 1 > budget_)
    file_.fail(ErrorCode::InputUnreadable, "the objects of the file refer to each other too often");
  budget_ -= size + 1;
  return bytes.substr(address, size);
}

std::string_view Hdf5Objects::data(std::uint64_t address, std::uint64_t size) const {
  const std::string_view bytes = file_.bytes();
  return address <= bytes.size() ? bytes.substr(address, size) : std::string_view();
}

const Hdf5Object& Hdf5Objects::at(std::uint64_t address) {
  const auto found = known_.find(address);
  return found != known_.end() ? found->second : known_.emplace(address, parse(address)).first->second;
}

Hdf5Object Hdf5Objects::parse(std::uint64_t address) {
  file_.check_cancelled();
  Hdf5Object object;
  std::vector<Block> blocks;
  bool is_new = false, have_order = false;
  if (data(address, 4) == "OHDR") {
    Cursor cursor(file_, data(address, 64));
    take(cursor, 5);
    const unsigned flags = cursor.read<std::uint8_t>();
    take(cursor, ((flags & 0x20u) != 0 ? 16 : 0) + ((flags & 0x10u) != 0 ? 4 : 0));
    is_new = true;
    have_order = (flags & 0x04u) != 0;
    const std::uint64_t size = read_number(cursor, 1u << (flags & 3u));
    const auto head = static_cast<std::uint64_t>(cursor.at() - file_.bytes().data());
    parse_new_messages(object, metadata(head, size), have_order, blocks);
  } else {
    Cursor cursor(file_, metadata(address, 16));
    if (cursor.read<std::uint8_t>() != 1) file_.fail("no header of an object", cursor.at() - 1);
    take(cursor, 7);
    const std::uint64_t size = cursor.read<std::uint32_t>();
    parse_old_messages(object, metadata(address + 16, size), blocks);
  }
  while (!blocks.empty()) {
    const Block block = blocks.back();
    blocks.pop_back();
    std::string_view bytes = metadata(block.address, block.size);
    if (!is_new) {
      parse_old_messages(object, bytes, blocks);
      continue;
    }
    if (!bytes.starts_with("OCHK") || bytes.size() < 8) fail(bytes, "a damaged header of an object");
    parse_new_messages(object, bytes.substr(4, bytes.size() - 8), have_order, blocks);
  }
  return object;
}

void Hdf5Objects::parse_old_messages(Hdf5Object& object, std::string_view bytes, std::vector<Block>& more) {
  Cursor cursor(file_, bytes);
  while (cursor.left() >= 8) {
    const unsigned type = cursor.read<std::uint16_t>();
    const std::size_t size = cursor.read<std::uint16_t>();
    const unsigned flags = cursor.read<std::uint8_t>();
    take(cursor, 3);
    parse_message(object, type, flags, take(cursor, size), more);
  }
}

void Hdf5Objects::parse_new_messages(Hdf5Object& object, std::string_view bytes, bool have_order,
                                     std::vector<Block>& more) {
  Cursor cursor(file_, bytes);
  const std::size_t head = have_order ? 6 : 4;
  while (cursor.left() >= head) {
    const unsigned type = cursor.read<std::uint8_t>();
    const std::size_t size = cursor.read<std::uint16_t>();
    const unsigned flags = cursor.read<std::uint8_t>();
    if (have_order) take(cursor, 2);
    parse_message(object, type, flags, take(cursor, size), more);
  }
}

void Hdf5Objects::parse_message(Hdf5Object& object, unsigned type, unsigned flags, std::string_view body,
                                std::vector<Block>& more) {
  constexpr unsigned kShared = 0x02;
  if ((flags & kShared) != 0) return;  // in another place; what it would say is missed where it is needed
  Cursor cursor(file_, body);
  switch (type) {
    case kHdf5Dataspace: object.shape = parse_dataspace(file_, body); break;
    case kHdf5Datatype: object.type = parse_datatype(file_, body); break;
    case kHdf5Layout: set_layout(object, body); break;
    case kHdf5Filters: add_filters(object, body); break;
    case kHdf5ExternalFiles: object.array.is_external = true; break;
    case kHdf5Link: add_link(object, body); break;
    case kHdf5LinkInfo: add_dense_links(object, body); break;
    case kHdf5Attribute: add_attribute(object, body); break;
    case kHdf5AttributeInfo: add_dense_attributes(object, body); break;
    case kHdf5Continuation: {
      const auto address = cursor.read<std::uint64_t>();
      more.push_back({address, cursor.read<std::uint64_t>()});
      break;
    }
    case kHdf5SymbolTable: {
      const auto tree = cursor.read<std::uint64_t>(), heap = cursor.read<std::uint64_t>();
      Cursor head(file_, metadata(heap, 32));
      if (take(head, 4) != "HEAP") fail(head.rest(), "no heap of names");
      take(head, 4);
      const auto size = head.read<std::uint64_t>();
      take(head, 8);
      add_symbols(object, tree, metadata(head.read<std::uint64_t>(), size), 0);
      break;
    }
    default: break;
  }
}

void Hdf5Objects::add_link(Hdf5Object& object, std::string_view body) const {
  Cursor cursor(file_, body);
  take(cursor, 1);
  const unsigned flags = cursor.read<std::uint8_t>();
  const unsigned type = (flags & 0x08u) != 0 ? cursor.read<std::uint8_t>() : 0;
  Hdf5Object::Member member;
  if ((flags & 0x04u) != 0) member.order = cursor.read<std::uint64_t>();
  if ((flags & 0x10u) != 0) take(cursor, 1);
  const std::string_view name = take(cursor, read_number(cursor, 1u << (flags & 3u)));
  if (type != 0) return;
  member.address = cursor.read<std::uint64_t>();
  object.members.insert_or_assign(std::string(name), member);
}

void Hdf5Objects::add_symbols(Hdf5Object& object, std::uint64_t tree, std::string_view names, int level) {
  constexpr std::uint64_t kNodeHead = 24, kSoftLink = 2;
  if (level > kHdf5MostLevels) fail(names, "a group whose B-tree is too deep");
  if (data(tree, 4) == "SNOD") {
    Cursor head(file_, metadata(tree, 8));
    take(head, 6);
    const std::uint64_t count = head.read<std::uint16_t>();
    Cursor cursor(file_, metadata(tree + 8, 40 * count));
    for (std::uint64_t i = 0; i < count; ++i) {
      const auto offset = cursor.read<std::uint64_t>(), address = cursor.read<std::uint64_t>();
      const bool is_soft = cursor.read<std::uint32_t>() == kSoftLink;
      take(cursor, 20);
      if (offset >= names.size()) fail(names, "a name beyond its heap");
      const std::string_view name = names.substr(offset, names.find('\0', offset) - offset);
      if (!is_soft) object.members.insert_or_assign(std::string(name), Hdf5Object::Member{address, 0});
    }
    return;
  }
  Cursor head(file_, metadata(tree, kNodeHead));
  if (take(head, 4) != "TREE") fail(head.rest(), "a damaged B-tree of a group");
  take(head, 2);
  const std::uint64_t count = head.read<std::uint16_t>();
  Cursor cursor(file_, metadata(tree + kNodeHead, 16 * count));
  for (std::uint64_t i = 0; i < count; ++i) {
    take(cursor, 8);
    add_symbols(object, cursor.read<std::uint64_t>(), names, level + 1);
  }
}

void Hdf5Objects::add_attribute(Hdf5Object& object, std::string_view body) const {
  Cursor cursor(file_, body);
  const unsigned version = cursor.read<std::uint8_t>(), flags = cursor.read<std::uint8_t>();
  const std::size_t name_bytes = cursor.read<std::uint16_t>(), type_bytes = cursor.read<std::uint16_t>(),
                    space_bytes = cursor.read<std::uint16_t>();
  if (version == 3) take(cursor, 1);
  if (version < 1 || version > 3 || (version > 1 && flags != 0)) return;  // with a shared type
  const auto part = [&](std::size_t size) { return take(cursor, version == 1 ? padded(size) : size).substr(0, size); };
  std::string_view name = part(name_bytes);
  name = name.substr(0, name.find('\0'));
  Hdf5AttributeValue value;
  value.type = parse_datatype(file_, part(type_bytes));
  value.shape = parse_dataspace(file_, part(space_bytes));
  value.data = cursor.rest();
  object.attributes.insert_or_assign(std::string(name), std::move(value));
}

void Hdf5Objects::add_filters(Hdf5Object& object, std::string_view body) const {
  constexpr unsigned kOptional = 1, kFirstWithName = 256;
  Cursor cursor(file_, body);
  const unsigned version = cursor.read<std::uint8_t>(), count = cursor.read<std::uint8_t>();
  if (version == 1) take(cursor, 6);
  for (unsigned i = 0; i < count; ++i) {
    const auto id = cursor.read<std::uint16_t>();
    const std::size_t name = version == 1 || id >= kFirstWithName ? cursor.read<std::uint16_t>() : 0;
    const unsigned flags = cursor.read<std::uint16_t>();
    const std::size_t values = cursor.read<std::uint16_t>();
    take(cursor, version == 1 ? padded(name) : name);
    take(cursor, 4 * (version == 1 ? (values + 1) / 2 * 2 : values));
    object.array.filters.push_back({id, (flags & kOptional) != 0});
  }
}

void Hdf5Objects::set_layout(Hdf5Object& object, std::string_view body) const {
  Hdf5Array& array = object.array;
  array.layout = Hdf5Array::Layout::Other;
  Cursor cursor(file_, body);
  const unsigned version = cursor.read<std::uint8_t>(), kind = cursor.read<std::uint8_t>();
  if (version < 3 || version > 4 || kind > 2) return;
  if (kind == 0) {
    array.layout = Hdf5Array::Layout::Compact;
    array.data = take(cursor, cursor.read<std::uint16_t>());
  } else if (kind == 1) {
    array.layout = Hdf5Array::Layout::Contiguous;
    const auto address = cursor.read<std::uint64_t>();
    array.data = data(address, cursor.read<std::uint64_t>());
  } else if (version == 3) {
    array.layout = Hdf5Array::Layout::Chunked;
    const unsigned rank = cursor.read<std::uint8_t>();
    array.chunk_index = cursor.read<std::uint64_t>();
    array.chunk_shape.clear();
    for (unsigned i = 0; i < rank; ++i) array.chunk_shape.push_back(cursor.read<std::uint32_t>());
  }
}

void Hdf5Objects::add_dense_links(Hdf5Object& object, std::string_view body) {
  constexpr std::size_t kHashBytes = 4;
  Cursor cursor(file_, body);
  take(cursor, 1);
  const unsigned flags = cursor.read<std::uint8_t>();
  if ((flags & 1u) != 0) take(cursor, 8);
  const auto heap = cursor.read<std::uint64_t>(), tree = cursor.read<std::uint64_t>();
  visit_dense(heap, tree, kHashBytes, [&](std::string_view link) { add_link(object, link); });
}

void Hdf5Objects::add_dense_attributes(Hdf5Object& object, std::string_view body) {
  Cursor cursor(file_, body);
  take(cursor, 1);
  const unsigned flags = cursor.read<std::uint8_t>();
  if ((flags & 1u) != 0) take(cursor, 2);
  const auto heap = cursor.read<std::uint64_t>(), tree = cursor.read<std::uint64_t>();
  visit_dense(heap, tree, 0, [&](std::string_view attribute) { add_attribute(object, attribute); });
}

void Hdf5Objects::visit_dense(std::uint64_t heap, std::uint64_t tree, std::size_t id_offset, const Visit& visit) {
  if (heap == kHdf5NoAddress || tree == kHdf5NoAddress) return;
  Hdf5Heap objects(*this, heap);
  visit_hdf5_records(*this, tree, id_offset, [&](std::string_view id) { visit(objects.object(id)); });
}

}  // namespace tetloom::detail

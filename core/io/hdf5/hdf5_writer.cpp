#include "core/io/hdf5/hdf5_writer_detail.hpp"

#include <array>
#include <cstring>

#include "core/io/hdf5/hdf5_detail.hpp"
#include "tetloom/error.hpp"

namespace tetloom::detail {
namespace {

constexpr std::size_t kAlignment = 8;
constexpr std::size_t kSuperblockBytes = 48;
constexpr std::size_t kLongestMessage = 0xffff;

template <class Number>
void append(std::string& bytes, Number value) {
  std::array<char, sizeof(Number)> raw;
  std::memcpy(raw.data(), &value, sizeof(Number));
  bytes.append(raw.data(), raw.size());
}

void append_bytes(std::string& bytes, std::initializer_list<int> values) {
  for (const int value : values) bytes += static_cast<char>(value);
}

void append_message(std::string& messages, Hdf5Message type, const std::string& body) {
  if (body.size() > kLongestMessage)
    throw Error(ErrorCode::InvalidArgument, "a name or an attribute is too long for an HDF5 file");
  messages += static_cast<char>(type);
  append(messages, static_cast<std::uint16_t>(body.size()));
  messages += '\0';  // flags
  messages += body;
}

void append_checksum(std::string& block) { append(block, hdf5_checksum(block)); }

std::string integer_type(std::size_t bytes, bool is_signed) {
  std::string type;
  append_bytes(type, {0x10, is_signed ? 0x08 : 0, 0, 0});
  append(type, static_cast<std::uint32_t>(bytes));
  append(type, std::uint16_t{0});
  append(type, static_cast<std::uint16_t>(8 * bytes));
  return type;
}

std::string double_type() {
  std::string type;
  append_bytes(type, {0x11, 0x20, 63, 0, 8, 0, 0, 0, 0, 0, 64, 0, 52, 11, 0, 52});
  append(type, std::uint32_t{1023});
  return type;
}

std::string float_type() {
  std::string type;
  append_bytes(type, {0x11, 0x20, 31, 0, 4, 0, 0, 0, 0, 0, 32, 0, 23, 8, 0, 23});
  append(type, std::uint32_t{127});
  return type;
}

// Ended by a zero, or filled up with them where there may be no room for one.
std::string text_type(const std::string& content) {
  std::string type;
  append_bytes(type, {0x13, content.ends_with('\0') ? 0 : 1, 0, 0});
  append(type, static_cast<std::uint32_t>(content.size()));
  return type;
}

// A field of characters, as MED has them.
std::string character_array_type(std::size_t bytes) {
  std::string type;
  append_bytes(type, {0x2a, 0, 0, 0});
  append(type, static_cast<std::uint32_t>(bytes));
  append_bytes(type, {1, 0, 0, 0});
  append(type, static_cast<std::uint32_t>(bytes));
  append(type, std::uint32_t{0});
  return type + integer_type(1, true);
}

std::string type_message(Hdf5Type type) {
  switch (type) {
    case Hdf5Type::Int8: return integer_type(1, true);
    case Hdf5Type::UInt8: return integer_type(1, false);
    case Hdf5Type::Int32: return integer_type(4, true);
    case Hdf5Type::UInt32: return integer_type(4, false);
    case Hdf5Type::Int64: return integer_type(8, true);
    case Hdf5Type::Float32: return float_type();
    case Hdf5Type::Float64: break;
  }
  return double_type();
}

std::size_t type_bytes(Hdf5Type type) {
  switch (type) {
    case Hdf5Type::Int8:
    case Hdf5Type::UInt8: return 1;
    case Hdf5Type::Int32:
    case Hdf5Type::UInt32:
    case Hdf5Type::Float32: return 4;
    default: return 8;
  }
}

// Of no dimension for a scalar.
std::string dataspace(std::span<const std::uint64_t> shape) {
  std::string space;
  append_bytes(space, {2, static_cast<int>(shape.size()), 0, shape.empty() ? 0 : 1});
  for (const std::uint64_t count : shape) append(space, count);
  return space;
}

template <class Value>
std::string_view bytes_of(std::span<const Value> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

std::string link_message(const std::string& name, std::uint64_t order, std::uint64_t address) {
  std::string link;
  append_bytes(link, {1, 0x04 | 0x10 | 0x01});  // has its order and its character set, and a length of two bytes
  append(link, order);
  link += '\1';  // UTF-8
  append(link, static_cast<std::uint16_t>(name.size()));
  link += name;
  append(link, address);
  return link;
}

std::string link_info(std::uint64_t members) {
  std::string info;
  append_bytes(info, {0, 0x01 | 0x02});  // the order is tracked and would be indexed
  append(info, members);
  for (int i = 0; i < 3; ++i) append(info, kHdf5NoAddress);  // all links stand in the header
  return info;
}

std::uint64_t aligned(std::uint64_t address) { return (address + kAlignment - 1) / kAlignment * kAlignment; }

void pad(AtomicFile& file) {
  while (file.position() % kAlignment != 0) file.put('\0');
}

std::string superblock(std::uint64_t root, std::uint64_t end) {
  std::string block(kHdf5Signature);
  append_bytes(block, {2, 8, 8, 0});
  for (const std::uint64_t address : {std::uint64_t{0}, kHdf5NoAddress, end, root}) append(block, address);
  append_checksum(block);
  return block;
}

}  // namespace

std::size_t Hdf5Writer::add_object(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  const std::string parent = slash == 0 ? "/" : path.substr(0, slash);
  if (!paths_.contains(parent)) add_group(parent);
  const std::size_t object = objects_.size();
  objects_.emplace_back();
  objects_[paths_.at(parent)].members.push_back({path.substr(slash + 1), object});
  paths_.emplace(path, object);
  return object;
}

void Hdf5Writer::add_group(const std::string& path) { add_object(path); }

void Hdf5Writer::add_array(const std::string& path, const std::string& type, std::size_t type_bytes,
                           std::span<const std::uint64_t> shape, Fill fill) {
  Object& array = objects_[add_object(path)];
  append_message(array.messages, kHdf5Dataspace, dataspace(shape));
  append_message(array.messages, kHdf5Datatype, type);
  append_message(array.messages, kHdf5FillValue, {3, 0x0a});  // the default one
  array.is_array = true;
  array.bytes = type_bytes;
  for (const std::uint64_t count : shape) array.bytes *= count;
  array.fill = std::move(fill);
}

void Hdf5Writer::add_array(const std::string& path, Hdf5Type type, std::vector<std::uint64_t> shape, Fill fill) {
  add_array(path, type_message(type), type_bytes(type), shape, std::move(fill));
}

void Hdf5Writer::add_characters(const std::string& path, const std::vector<std::string>& texts, std::size_t bytes) {
  std::string content;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    content += texts[i].substr(0, bytes);
    content.resize((i + 1) * bytes, '\0');
  }
  const std::array<std::uint64_t, 1> shape{texts.size()};
  add_array(path, character_array_type(bytes), bytes, shape,
            [content = std::move(content)](AtomicFile& file) { file.write(content); });
}

void Hdf5Writer::put_attribute(const std::string& object, std::string_view name, const std::string& type,
                               const std::string& space, std::string_view bytes) {
  std::string attribute;
  append_bytes(attribute, {3, 0});
  append(attribute, static_cast<std::uint16_t>(name.size() + 1));
  append(attribute, static_cast<std::uint16_t>(type.size()));
  append(attribute, static_cast<std::uint16_t>(space.size()));
  attribute += '\0';  // ASCII
  attribute += name;
  attribute += '\0';
  attribute += type;
  attribute += space;
  attribute += bytes;
  append_message(object_at(object).messages, kHdf5Attribute, attribute);
}

void Hdf5Writer::put(const std::string& object, std::string_view name, std::int32_t value) {
  put_attribute(object, name, integer_type(4, true), dataspace({}), bytes_of(std::span<const std::int32_t>(&value, 1)));
}

void Hdf5Writer::put(const std::string& object, std::string_view name, std::span<const std::int64_t> values) {
  const std::array<std::uint64_t, 1> shape{values.size()};
  put_attribute(object, name, integer_type(8, true), dataspace(shape), bytes_of(values));
}

void Hdf5Writer::put(const std::string& object, std::string_view name, std::span<const std::int32_t> values) {
  const std::array<std::uint64_t, 1> shape{values.size()};
  put_attribute(object, name, integer_type(4, true), dataspace(shape), bytes_of(values));
}

void Hdf5Writer::put(const std::string& object, std::string_view name, double value) {
  put_attribute(object, name, double_type(), dataspace({}), bytes_of(std::span<const double>(&value, 1)));
}

void Hdf5Writer::put(const std::string& object, std::string_view name, const std::string& text, std::size_t bytes) {
  std::string content = text;
  content.resize(bytes == 0 ? text.size() + 1 : bytes, '\0');
  put_attribute(object, name, text_type(content), dataspace({}), content);
}

std::string Hdf5Writer::header_of(const Object& object, std::span<const std::uint64_t> addresses,
                                  std::uint64_t data) const {
  std::string messages;
  if (object.is_array) {
    std::string layout;
    append_bytes(layout, {3, 1});  // contiguous
    append(layout, object.bytes == 0 ? kHdf5NoAddress : data);
    append(layout, object.bytes);
    append_message(messages, kHdf5Layout, layout);
  } else {
    append_message(messages, kHdf5LinkInfo, link_info(object.members.size()));
    append_message(messages, kHdf5GroupInfo, std::string(2, '\0'));
    for (std::size_t i = 0; i < object.members.size(); ++i)
      append_message(messages, kHdf5Link, link_message(object.members[i].name, i, addresses[object.members[i].object]));
  }
  messages += object.messages;
  std::string header = "OHDR";
  append_bytes(header, {2, 0x02});  // the size has four bytes
  append(header, static_cast<std::uint32_t>(messages.size()));
  header += messages;
  append_checksum(header);
  return header;
}

void Hdf5Writer::write(AtomicFile& file) const {
  std::vector<std::uint64_t> addresses(objects_.size(), 0), data(objects_.size(), 0);
  std::uint64_t end = kSuperblockBytes;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    addresses[i] = end;
    end = aligned(end + header_of(objects_[i], addresses, 0).size());
  }
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    data[i] = end;
    end = aligned(end + objects_[i].bytes);
  }
  file.write(superblock(addresses[0], end));
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    file.write(header_of(objects_[i], addresses, data[i]));
    pad(file);
  }
  for (const Object& object : objects_) {
    if (object.fill) object.fill(file);
    pad(file);
  }
}

}  // namespace tetloom::detail

#include "core/io/hdf5/hdf5_reader_detail.hpp"

#include <algorithm>

#include "core/io/hdf5/hdf5_chunks_detail.hpp"
#include "core/io/vtu_detail.hpp"

namespace tetloom::detail {
namespace {

std::optional<ScalarType> scalar_of(const Hdf5Datatype& type) {
  using enum ScalarType;
  if (type.kind == Hdf5Class::Real)
    return type.bytes == 8 ? std::optional(Float64) : type.bytes == 4 ? std::optional(Float32) : std::nullopt;
  if (type.kind != Hdf5Class::Integer) return {};
  switch (type.bytes) {
    case 1: return type.is_signed ? Int8 : UInt8;
    case 2: return type.is_signed ? Int16 : UInt16;
    case 4: return type.is_signed ? Int32 : UInt32;
    case 8: return type.is_signed ? Int64 : UInt64;
    default: return {};
  }
}

std::string without_padding(std::string_view text) {
  text = text.substr(0, text.find('\0'));
  while (!text.empty() && Cursor::is_space(text.back())) text.remove_suffix(1);
  return std::string(text);
}

}  // namespace

void Hdf5Reader::fail(ErrorCode code, const std::string& path, const std::string& what) const {
  objects_.file().fail(code, "'" + path + "' " + what);
}

const Hdf5Object* Hdf5Reader::find(const std::string& path) {
  const Hdf5Object* object = &objects_.at(objects_.root());
  for (std::size_t begin = 1; begin < path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    const auto member = object->members.find(std::string_view(path).substr(begin, end - begin));
    if (member == object->members.end()) return nullptr;
    object = &objects_.at(member->second.address);
    begin = end + 1;
  }
  return object;
}

const Hdf5Object& Hdf5Reader::require(const std::string& path) {
  const Hdf5Object* const object = find(path);
  if (object == nullptr) fail(ErrorCode::InputUnreadable, path, "is not in the file");
  return *object;
}

std::vector<std::string> Hdf5Reader::names_in(const std::string& path) {
  const Hdf5Object* const group = find(path);
  if (group == nullptr) return {};
  std::vector<std::pair<std::uint64_t, std::string>> members;
  for (const auto& [name, member] : group->members) members.emplace_back(member.order, name);
  std::ranges::sort(members);
  std::vector<std::string> names;
  for (auto& [order, name] : members) names.push_back(std::move(name));
  return names;
}

bool Hdf5Reader::has_attribute(const std::string& object, std::string_view name) {
  const Hdf5Object* const owner = find(object);
  return owner != nullptr && owner->attributes.contains(name);
}

std::int64_t Hdf5Reader::attribute(const std::string& object, std::string_view name) {
  const auto& attributes = require(object).attributes;
  const auto found = attributes.find(name);
  if (found == attributes.end())
    fail(ErrorCode::InputUnreadable, object, "has no attribute '" + std::string(name) + "'");
  const auto& [type, shape, data] = found->second;
  const auto scalar = scalar_of(type);
  if (!scalar || type.kind != Hdf5Class::Integer || data.size() < type.bytes)
    fail(ErrorCode::InputUnreadable, object, "has no number as its attribute '" + std::string(name) + "'");
  return VtuArray(*scalar, data.substr(0, type.bytes), type.is_big_endian).integer(0);
}

std::string Hdf5Reader::text_attribute(const std::string& object, std::string_view name) {
  const auto& attributes = require(object).attributes;
  const auto found = attributes.find(name);
  if (found == attributes.end() || found->second.type.kind != Hdf5Class::String) return {};
  return without_padding(found->second.data.substr(0, found->second.type.bytes));
}

std::vector<std::uint64_t> Hdf5Reader::shape(const std::string& path) {
  return require(path).shape.value_or(std::vector<std::uint64_t>{0});
}

// No more than the file holds is made room for.
Hdf5Reader::Values Hdf5Reader::read(const std::string& path) {
  const Hdf5Object& object = require(path);
  if (!object.type || object.array.layout == Hdf5Array::Layout::None)
    fail(ErrorCode::InputUnreadable, path, "is no array");
  Values values{*object.type, object.shape ? 1u : 0u, {}, {}};
  if (object.array.is_external || object.array.layout == Hdf5Array::Layout::Other)
    fail(ErrorCode::InputUnsuitable, path, "is an array that lies in another file, or in a form of HDF5 1.10");
  std::uint64_t bytes = values.type.bytes;
  const auto multiply = [&](std::uint64_t& product, std::uint64_t factor) {
    if (factor != 0 && product > (std::uint64_t{1} << 62) / factor)
      fail(ErrorCode::InputUnreadable, path, "has a size that exceeds the file");
    product *= factor;
  };
  if (object.shape)
    for (const std::uint64_t extent : *object.shape) multiply(values.count, extent);
  multiply(bytes, values.count);
  if (bytes == 0) {
    values.count = 0;
    return values;
  }
  if (object.array.layout == Hdf5Array::Layout::Chunked) {
    values.owned = read_hdf5_chunks(objects_, object.array, *object.shape, bytes);
    return values;
  }
  values.in_file = object.array.data.substr(0, bytes);
  if (values.in_file.size() < bytes) fail(ErrorCode::InputUnreadable, path, "has a size that exceeds the file");
  return values;
}

std::vector<std::int64_t> Hdf5Reader::integers(const std::string& path) {
  const Values values = read(path);
  const auto type = scalar_of(values.type);
  if (!type || values.type.kind != Hdf5Class::Integer) fail(ErrorCode::InputUnreadable, path, "holds no integers");
  const std::string_view bytes = values.bytes();
  const VtuArray array(*type, bytes, values.type.is_big_endian);
  std::vector<std::int64_t> numbers(values.count);
  for (std::uint64_t i = 0; i < values.count; ++i) numbers[i] = array.integer(i);
  return numbers;
}

std::vector<double> Hdf5Reader::reals(const std::string& path) {
  const Values values = read(path);
  const auto type = scalar_of(values.type);
  if (!type) fail(ErrorCode::InputUnreadable, path, "holds no numbers");
  const std::string_view bytes = values.bytes();
  const VtuArray array(*type, bytes, values.type.is_big_endian);
  std::vector<double> numbers(values.count);
  for (std::uint64_t i = 0; i < values.count; ++i) numbers[i] = array.real(i);
  return numbers;
}

std::vector<std::string> Hdf5Reader::texts(const std::string& path) {
  const Values values = read(path);
  // MED and others keep characters as integers of one byte as well, in rows.
  const bool is_text = values.type.kind == Hdf5Class::String;
  if (!is_text && (values.type.kind != Hdf5Class::Integer || values.type.bytes != 1))
    fail(ErrorCode::InputUnreadable, path, "holds no texts");
  const std::string_view bytes = values.bytes();
  const auto extents = shape(path);
  const std::uint64_t width = is_text ? values.type.bytes : extents.empty() ? 1 : extents.back();
  std::vector<std::string> texts;
  for (std::uint64_t at = 0; width > 0 && at < bytes.size(); at += width)
    texts.push_back(without_padding(bytes.substr(at, width)));
  return texts;
}

}  // namespace tetloom::detail

#include "core/io/netcdf/netcdf_writer_detail.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "tetloom/assert.hpp"

namespace tetloom::detail {
namespace {

constexpr std::uint64_t kMostBytes = 0xfffffffc;  // of a variable of the form Offset64
constexpr std::size_t kNetcdfAlignment = 4;
constexpr std::int32_t kDimensionList = 10, kVariableList = 11, kAttributeList = 12;

constexpr std::uint64_t padded(std::uint64_t bytes) {
  return (bytes + kNetcdfAlignment - 1) / kNetcdfAlignment * kNetcdfAlignment;
}

constexpr std::uint64_t bytes_of(NetcdfType type) {
  switch (type) {
    case NetcdfType::Char: return 1;
    case NetcdfType::Float64: return 8;
    default: return 4;
  }
}

template <class Number>
void append_swapped(std::string& bytes, Number value) {
  const auto raw = std::bit_cast<std::array<char, sizeof(Number)>>(byte_swapped(value));
  bytes.append(raw.data(), raw.size());
}

}  // namespace

/// The head of a file, put together.
class NetcdfWriter::Head {
 public:
  explicit Head(NetcdfForm form) : form_(form), bytes_("CDF") { bytes_ += static_cast<char>(form); }

  void put(std::int32_t number) { append_swapped(bytes_, number); }
  void put(NetcdfType type) { put(static_cast<std::int32_t>(type)); }
  void put_offset(std::uint64_t offset) { append_swapped(bytes_, offset); }
  void put_count(std::uint64_t count) {
    form_ == NetcdfForm::Data64 ? append_swapped(bytes_, count)
                                : append_swapped(bytes_, static_cast<std::uint32_t>(count));
  }
  void put_list(std::int32_t kind, std::size_t count) {
    put(count > 0 ? kind : 0);
    put_count(count);
  }
  void put_padded(std::string_view bytes) {
    bytes_ += bytes;
    bytes_.resize(padded(bytes_.size()), '\0');
  }
  void put_name(const std::string& name) {
    put_count(name.size());
    put_padded(name);
  }
  void put_attributes(const std::vector<Attribute>& attributes) {
    put_list(kAttributeList, attributes.size());
    for (const Attribute& attribute : attributes) {
      put_name(attribute.name);
      put(attribute.type);
      put_count(attribute.count);
      put_padded(attribute.bytes);
    }
  }
  const std::string& bytes() const { return bytes_; }

 private:
  NetcdfForm form_;
  std::string bytes_;
};

NetcdfWriter::Dimension NetcdfWriter::add_dimension(const std::string& name, std::uint64_t length) {
  TETLOOM_ASSERT(length > 0);
  dimensions_.push_back({name, length});
  return dimensions_.size() - 1;
}

NetcdfWriter::Dimension NetcdfWriter::add_growing_dimension(const std::string& name) {
  dimensions_.push_back({name, 0});
  return dimensions_.size() - 1;
}

void NetcdfWriter::put(const std::string& name, std::int32_t value) {
  attributes_.push_back({name, NetcdfType::Int32, 1, {}});
  append_swapped(attributes_.back().bytes, value);
}

void NetcdfWriter::put(const std::string& name, float value) {
  attributes_.push_back({name, NetcdfType::Float32, 1, {}});
  append_swapped(attributes_.back().bytes, value);
}

void NetcdfWriter::put(const std::string& name, const std::string& text) {
  attributes_.push_back({name, NetcdfType::Char, text.size(), text});
}

void NetcdfWriter::add_variable(const std::string& name, NetcdfType type, const Dimensions& dimensions, Fill fill) {
  variables_.push_back({name, type, dimensions, {}, std::move(fill)});
}

void NetcdfWriter::add_integers(const std::string& name, Dimension dimension, std::vector<std::int32_t> values) {
  TETLOOM_ASSERT(values.size() == dimensions_[dimension].length);
  add_variable(name, NetcdfType::Int32, {dimension}, [values = std::move(values)](AtomicFile& file) {
    for (const std::int32_t value : values) file.put(byte_swapped(value));
  });
}

void NetcdfWriter::add_texts(const std::string& name, Dimension count, Dimension width,
                             const std::vector<std::string>& texts) {
  const std::uint64_t bytes = dimensions_[width].length;
  std::string content;
  for (const std::string& text : texts) {
    TETLOOM_ASSERT(text.size() < bytes);
    content += text;
    content.append(bytes - text.size(), '\0');
  }
  TETLOOM_ASSERT(texts.size() == dimensions_[count].length);
  add_variable(name, NetcdfType::Char, {count, width},
               [content = std::move(content)](AtomicFile& file) { file.write(content); });
}

void NetcdfWriter::put_on_variable(const std::string& name, const std::string& text) {
  variables_.back().attributes.push_back({name, NetcdfType::Char, text.size(), text});
}

bool NetcdfWriter::grows(const Variable& variable) const {
  return !variable.dimensions.empty() && dimensions_[variable.dimensions[0]].length == 0;
}

std::uint64_t NetcdfWriter::bytes_of(const Variable& variable) const {
  std::uint64_t bytes = detail::bytes_of(variable.type);
  for (const Dimension dimension : variable.dimensions)
    bytes *= std::max<std::uint64_t>(dimensions_[dimension].length, 1);
  return bytes;
}

NetcdfForm NetcdfWriter::needed_form() const {
  const auto is_small = [this](const Variable& variable) { return bytes_of(variable) <= kMostBytes; };
  return std::ranges::all_of(variables_, is_small) ? NetcdfForm::Offset64 : NetcdfForm::Data64;
}

std::string NetcdfWriter::make_head(NetcdfForm form, const std::vector<std::uint64_t>& begins) const {
  Head head(form);
  head.put_count(0);  // records
  head.put_list(kDimensionList, dimensions_.size());
  for (const NamedLength& dimension : dimensions_) {
    head.put_name(dimension.name);
    head.put_count(dimension.length);
  }
  head.put_attributes(attributes_);
  head.put_list(kVariableList, variables_.size());
  for (std::size_t i = 0; i < variables_.size(); ++i) {
    const Variable& variable = variables_[i];
    head.put_name(variable.name);
    head.put_count(variable.dimensions.size());
    for (const Dimension dimension : variable.dimensions) head.put_count(dimension);
    head.put_attributes(variable.attributes);
    head.put(variable.type);
    head.put_count(padded(bytes_of(variable)));
    head.put_offset(begins[i]);
  }
  return head.bytes();
}

// Variables that grow begin behind all others, and have nothing there yet.
void NetcdfWriter::write(AtomicFile& file, NetcdfForm form) const {
  std::vector<std::uint64_t> begins(variables_.size(), 0);
  std::uint64_t end = make_head(form, begins).size();
  for (const bool growing : {false, true})
    for (std::size_t i = 0; i < variables_.size(); ++i) {
      if (grows(variables_[i]) != growing) continue;
      begins[i] = end;
      end += padded(bytes_of(variables_[i]));
    }
  file.write(make_head(form, begins));
  for (const Variable& variable : variables_) {
    if (grows(variable)) continue;
    const std::uint64_t stop = file.position() + padded(bytes_of(variable));
    if (variable.fill) variable.fill(file);
    while (file.position() < stop) file.put('\0');
    TETLOOM_ASSERT(file.position() == stop);
  }
}

}  // namespace tetloom::detail

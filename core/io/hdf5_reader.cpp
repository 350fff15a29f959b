#include <algorithm>
#include <cstring>
#include <limits>
#include <new>

#include "core/io/hdf5_detail.hpp"

namespace tetloom::detail {
namespace {

constexpr std::uint64_t kMostInflation = 1032;  // of deflate

/// A driver for HDF5 that reads a file in memory. Its own drivers go through a buffer which addresses that are
/// damaged lead out of; this one names no features, so that there is no buffer, and refuses what is not in the file.
struct Image {
  H5FD_t base;  // the first member, as HDF5 wants it
  std::string_view bytes;
  haddr_t end = 0;  // of the addresses in use
};

Image& image_of(const H5FD_t* file) { return *reinterpret_cast<Image*>(const_cast<H5FD_t*>(file)); }

// What is opened next; QuietHdf5 lets one thread at a time in here.
std::string_view opened_next;

H5FD_t* open_driver(const char*, unsigned, hid_t, haddr_t) {
  auto* const image = new (std::nothrow) Image{{}, opened_next};
  return image == nullptr ? nullptr : &image->base;
}

herr_t close_driver(H5FD_t* file) {
  delete &image_of(file);
  return 0;
}

herr_t query_driver(const H5FD_t*, unsigned long* features) {
  *features = 0;
  return 0;
}

haddr_t get_end(const H5FD_t* file, H5FD_mem_t) { return image_of(file).end; }

herr_t set_end(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  image_of(file).end = end;
  return 0;
}

haddr_t get_size(const H5FD_t* file, H5FD_mem_t) { return image_of(file).bytes.size(); }

herr_t read_driver(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, size_t size, void* out) {
  const std::string_view bytes = image_of(file).bytes;
  if (address > bytes.size() || size > bytes.size() - address) return -1;
  std::memcpy(out, bytes.data() + address, size);
  return 0;
}

herr_t write_driver(H5FD_t*, H5FD_mem_t, hid_t, haddr_t, size_t, const void*) { return -1; }

hid_t open_image(std::string_view bytes) {
  H5FD_class_t driver{};
  driver.name = "tetloom_memory";
  driver.maxaddr = std::numeric_limits<std::int64_t>::max();
  driver.fc_degree = H5F_CLOSE_STRONG;
  driver.open = open_driver;
  driver.close = close_driver;
  driver.query = query_driver;
  driver.get_eoa = get_end;
  driver.set_eoa = set_end;
  driver.get_eof = get_size;
  driver.read = read_driver;
  driver.write = write_driver;
  std::fill(std::begin(driver.fl_map), std::end(driver.fl_map), H5FD_MEM_SUPER);
  const H5Handle known(H5FDregister(&driver), H5FDunregister);
  const H5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  if (!known.valid() || H5Pset_driver(access.get(), known.get(), nullptr) < 0) return -1;
  opened_next = bytes;
  return H5Fopen("tetloom image", H5F_ACC_RDONLY, access.get());
}

std::string without_end(const char* text, std::size_t size) {
  std::string name(text, ::strnlen(text, size));
  while (!name.empty() && name.back() == ' ') name.pop_back();
  return name;
}

}  // namespace

Hdf5Reader::Hdf5Reader(const InputFile& file) : source_(file), file_(open_image(file.bytes()), H5Fclose) {
  if (!file_.valid()) fail("is no HDF5 file, or a damaged one");
}

void Hdf5Reader::fail(const std::string& what) const { source_.fail(ErrorCode::InputUnreadable, what); }

bool Hdf5Reader::has(const std::string& path) const {
  for (std::size_t slash = path.find('/', 1);; slash = path.find('/', slash + 1)) {
    const std::string part = path.substr(0, slash);
    H5L_info_t info;
    if (H5Lget_info(file_.get(), part.c_str(), &info, H5P_DEFAULT) < 0 || info.type != H5L_TYPE_HARD) return false;
    if (slash == std::string::npos) return true;
  }
}

std::vector<std::string> Hdf5Reader::names_in(const std::string& path) const {
  std::vector<std::string> names;
  if (!has(path)) return names;
  const H5Handle group(H5Gopen2(file_.get(), path.c_str(), H5P_DEFAULT), H5Gclose);
  if (!group.valid()) fail("'" + path + "' is no group");
  const auto add = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
    try {
      static_cast<std::vector<std::string>*>(list)->emplace_back(name);
      return 0;
    } catch (...) {
      return -1;
    }
  };
  // In the order in which they lie: HDF5 1.10 frees memory that it never had when it sorts links that are damaged.
  if (H5Literate(group.get(), H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, add, &names) < 0)
    fail("the group '" + path + "' is damaged");
  std::ranges::sort(names);
  return names;
}

std::int64_t Hdf5Reader::attribute(const std::string& object, const char* name) const {
  std::int64_t value = 0;
  const H5Handle owner(has(object) ? H5Oopen(file_.get(), object.c_str(), H5P_DEFAULT) : -1, H5Oclose);
  const H5Handle attribute(owner.valid() ? H5Aopen(owner.get(), name, H5P_DEFAULT) : -1, H5Aclose);
  const H5Handle space(attribute.valid() ? H5Aget_space(attribute.get()) : -1, H5Sclose);
  const bool one = space.valid() && H5Sget_simple_extent_npoints(space.get()) == 1;
  if (!one || H5Aread(attribute.get(), H5T_NATIVE_INT64, &value) < 0)
    fail("'" + object + "' has no attribute '" + name + "'");
  return value;
}

// What the file does not hold is neither read nor made room for; data in other files are refused.
H5Handle Hdf5Reader::open_array(const std::string& path, std::size_t& count, std::size_t bytes_each) const {
  H5Handle array(has(path) ? H5Dopen2(file_.get(), path.c_str(), H5P_DEFAULT) : -1, H5Dclose);
  if (!array.valid()) fail("has no array '" + path + "'");
  const H5Handle space(H5Dget_space(array.get()), H5Sclose);
  const hssize_t points = space.valid() ? H5Sget_simple_extent_npoints(space.get()) : -1;
  const H5Handle type(H5Dget_type(array.get()), H5Tclose);
  const H5Handle made(H5Dget_create_plist(array.get()), H5Pclose);
  if (points < 0 || !type.valid() || !made.valid()) fail("the array '" + path + "' is damaged");
  if (H5Pget_external_count(made.get()) != 0 || H5Pget_layout(made.get()) == H5D_VIRTUAL)
    fail("the array '" + path + "' lies in another file");
  const std::uint64_t stored = std::min<std::uint64_t>(H5Dget_storage_size(array.get()), source_.bytes().size());
  const std::uint64_t most = H5Pget_nfilters(made.get()) > 0 ? stored * kMostInflation : stored;
  const std::size_t size = std::max<std::size_t>(1, H5Tget_size(type.get()));
  if (static_cast<std::uint64_t>(points) > most / size || size * 8 < bytes_each)
    fail("the array '" + path + "' has a count of " + std::to_string(points) + ", which exceeds the file");
  count = static_cast<std::size_t>(points);
  return array;
}

std::vector<std::int64_t> Hdf5Reader::integers(const std::string& path) const {
  std::size_t count = 0;
  const H5Handle array = open_array(path, count, sizeof(std::int64_t));
  std::vector<std::int64_t> values(count);
  if (count > 0 && H5Dread(array.get(), H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    fail("the array '" + path + "' is damaged");
  return values;
}

std::vector<double> Hdf5Reader::reals(const std::string& path) const {
  std::size_t count = 0;
  const H5Handle array = open_array(path, count, sizeof(double));
  std::vector<double> values(count);
  if (count > 0 && H5Dread(array.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    fail("the array '" + path + "' is damaged");
  return values;
}

std::vector<std::string> Hdf5Reader::names(const std::string& path) const {
  std::size_t count = 0;
  const H5Handle array = open_array(path, count, 1);
  const H5Handle type(H5Dget_type(array.get()), H5Tclose);
  const std::size_t size = H5Tget_size(type.get());
  if (H5Tis_variable_str(type.get()) != 0 || H5Tdetect_class(type.get(), H5T_VLEN) != 0 ||
      H5Tdetect_class(type.get(), H5T_REFERENCE) != 0)
    fail("the array '" + path + "' holds no names of a fixed length");
  std::vector<char> bytes(count * size);
  if (count > 0 && H5Dread(array.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) < 0)
    fail("the array '" + path + "' is damaged");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) names.push_back(without_end(bytes.data() + i * size, size));
  return names;
}

}  // namespace tetloom::detail

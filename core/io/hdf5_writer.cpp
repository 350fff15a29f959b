#include <cstring>

#include "core/io/hdf5_detail.hpp"
#include "tetloom/error.hpp"

namespace tetloom::detail {
namespace {

std::mutex& hdf5_mutex() {
  static std::mutex mutex;
  return mutex;
}

template <class Value>
hid_t type_of();
template <>
hid_t type_of<double>() {
  return H5T_NATIVE_DOUBLE;
}
template <>
hid_t type_of<std::int32_t>() {
  return H5T_NATIVE_INT32;
}

}  // namespace

QuietHdf5::QuietHdf5() : lock_(hdf5_mutex()) {
  H5Eget_auto2(H5E_DEFAULT, &handler_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

QuietHdf5::~QuietHdf5() { H5Eset_auto2(H5E_DEFAULT, handler_, data_); }

Hdf5Writer::Hdf5Writer(AtomicFile& file)
    : target_(file), file_(H5Fcreate(file.path().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose) {
  checked(file_.get());
}

hid_t Hdf5Writer::checked(hid_t id) const {
  if (id < 0) throw Error(ErrorCode::OutputFailed, "cannot write '" + target_.target().string() + "' with HDF5");
  return id;
}

void Hdf5Writer::make_group(const std::string& path) {
  // libmed asks for the members of a group in the order in which they were made, which parents that H5Gcreate2 makes
  // by itself do not keep.
  const H5Handle order(checked(H5Pcreate(H5P_GROUP_CREATE)), H5Pclose);
  checked(H5Pset_link_creation_order(order.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED));
  for (std::size_t slash = path.find('/', 1);; slash = path.find('/', slash + 1)) {
    const std::string part = path.substr(0, slash);
    if (H5Lexists(file_.get(), part.c_str(), H5P_DEFAULT) <= 0) {
      const H5Handle group(checked(H5Gcreate2(file_.get(), part.c_str(), H5P_DEFAULT, order.get(), H5P_DEFAULT)),
                           H5Gclose);
    }
    if (slash == std::string::npos) return;
  }
}

void Hdf5Writer::put_attribute(const std::string& object, const char* name, hid_t type, const void* value) {
  const H5Handle owner(checked(H5Oopen(file_.get(), object.c_str(), H5P_DEFAULT)), H5Oclose);
  const H5Handle space(checked(H5Screate(H5S_SCALAR)), H5Sclose);
  const H5Handle attribute(checked(H5Acreate2(owner.get(), name, type, space.get(), H5P_DEFAULT, H5P_DEFAULT)),
                           H5Aclose);
  checked(H5Awrite(attribute.get(), type, value));
}

void Hdf5Writer::put(const std::string& object, const char* name, std::int32_t value) {
  put_attribute(object, name, H5T_NATIVE_INT32, &value);
}

void Hdf5Writer::put(const std::string& object, const char* name, double value) {
  put_attribute(object, name, H5T_NATIVE_DOUBLE, &value);
}

void Hdf5Writer::put(const std::string& object, const char* name, const std::string& text) {
  const H5Handle type(checked(H5Tcopy(H5T_C_S1)), H5Tclose);
  checked(H5Tset_size(type.get(), text.size() + 1));
  put_attribute(object, name, type.get(), text.c_str());
}

void Hdf5Writer::put_array(const std::string& path, const std::vector<std::int32_t>& values) {
  put_components<std::int32_t>(path, values.size(), 1, [&](std::size_t, std::int32_t* out) {
    std::memcpy(out, values.data(), values.size() * sizeof(std::int32_t));
  });
}

template <class Value>
void Hdf5Writer::put_components(const std::string& path, std::size_t count, std::size_t components,
                                const std::function<void(std::size_t, Value*)>& fill) {
  const hsize_t all = count * components, one = count;
  const H5Handle space(checked(H5Screate_simple(1, &all, nullptr)), H5Sclose);
  const H5Handle part(checked(H5Screate_simple(1, &one, nullptr)), H5Sclose);
  const H5Handle array(checked(H5Dcreate2(file_.get(), path.c_str(), type_of<Value>(), space.get(), H5P_DEFAULT,
                                          H5P_DEFAULT, H5P_DEFAULT)),
                       H5Dclose);
  const auto values = std::make_unique_for_overwrite<Value[]>(count);
  for (std::size_t component = 0; component < components; ++component) {
    target_.check_cancelled();
    fill(component, values.get());
    const hsize_t start = component * count;
    checked(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, &start, nullptr, &one, nullptr));
    checked(H5Dwrite(array.get(), type_of<Value>(), part.get(), space.get(), H5P_DEFAULT, values.get()));
  }
}

template void Hdf5Writer::put_components<double>(const std::string&, std::size_t, std::size_t,
                                                 const std::function<void(std::size_t, double*)>&);
template void Hdf5Writer::put_components<std::int32_t>(const std::string&, std::size_t, std::size_t,
                                                       const std::function<void(std::size_t, std::int32_t*)>&);

void Hdf5Writer::put_names(const std::string& path, const std::vector<std::string>& names) {
  constexpr hsize_t kBytes = 80;
  const hsize_t count = names.size();
  std::vector<char> bytes(count * kBytes, '\0');
  for (std::size_t i = 0; i < count; ++i) names[i].copy(bytes.data() + i * kBytes, kBytes);
  const H5Handle type(checked(H5Tarray_create2(H5T_NATIVE_INT8, 1, &kBytes)), H5Tclose);
  const H5Handle space(checked(H5Screate_simple(1, &count, nullptr)), H5Sclose);
  const H5Handle array(
      checked(H5Dcreate2(file_.get(), path.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)),
      H5Dclose);
  checked(H5Dwrite(array.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()));
}

void Hdf5Writer::finish() { checked(H5Fflush(file_.get(), H5F_SCOPE_GLOBAL)); }

}  // namespace tetloom::detail

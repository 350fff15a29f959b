#pragma once
// HDF5 as the formats over it use it: scalar attributes and one-dimensional arrays, under absolute paths. One file is
// open at a time; the library prints nothing and calls nobody else's error handler meanwhile.
#include <hdf5.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/io/atomic_file.hpp"
#include "core/io/input_detail.hpp"

namespace tetloom::detail {

/// Owns an identifier of HDF5.
class H5Handle {
 public:
  H5Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~H5Handle() {
    if (id_ >= 0) close_(id_);
  }
  H5Handle(H5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  H5Handle(const H5Handle&) = delete;
  H5Handle& operator=(const H5Handle&) = delete;
  hid_t get() const { return id_; }
  bool valid() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// While it lives no other thread is in here, and errors of HDF5 are not printed.
class QuietHdf5 {
 public:
  QuietHdf5();
  ~QuietHdf5();
  QuietHdf5(const QuietHdf5&) = delete;
  QuietHdf5& operator=(const QuietHdf5&) = delete;

 private:
  std::lock_guard<std::mutex> lock_;
  H5E_auto2_t handler_ = nullptr;
  void* data_ = nullptr;
};

/// Writes the temporary of an AtomicFile. Errors: OutputFailed with its path; Cancelled between two arrays.
class Hdf5Writer {
 public:
  explicit Hdf5Writer(AtomicFile& file);

  void make_group(const std::string& path);
  void put(const std::string& object, const char* name, std::int32_t value);
  void put(const std::string& object, const char* name, double value);
  void put(const std::string& object, const char* name, const std::string& text);
  void put_array(const std::string& path, const std::vector<std::int32_t>& values);
  /// `components` arrays of `count` values, one after the other; fill(component, out) gives one of them.
  template <class Value>
  void put_components(const std::string& path, std::size_t count, std::size_t components,
                      const std::function<void(std::size_t, Value*)>& fill);
  /// Names in fields of 80 bytes.
  void put_names(const std::string& path, const std::vector<std::string>& names);
  /// Closes the file; nothing may be written afterwards.
  void finish();

 private:
  void put_attribute(const std::string& object, const char* name, hid_t type, const void* value);
  hid_t checked(hid_t id) const;

  QuietHdf5 quiet_;
  AtomicFile& target_;
  H5Handle file_;
};

/// Reads from the bytes of a file in memory. Errors: InputUnreadable with the path of the object.
class Hdf5Reader {
 public:
  explicit Hdf5Reader(const InputFile& file);

  bool has(const std::string& path) const;
  /// The names in a group, ascending. Links to elsewhere are refused.
  std::vector<std::string> names_in(const std::string& group) const;
  std::int64_t attribute(const std::string& object, const char* name) const;
  std::vector<std::int64_t> integers(const std::string& path) const;
  std::vector<double> reals(const std::string& path) const;
  /// Names in fields of any number of bytes.
  std::vector<std::string> names(const std::string& path) const;

 private:
  H5Handle open_array(const std::string& path, std::size_t& count, std::size_t bytes_each) const;
  [[noreturn]] void fail(const std::string& what) const;

  QuietHdf5 quiet_;
  const InputFile& source_;
  H5Handle file_;
};

}  // namespace tetloom::detail

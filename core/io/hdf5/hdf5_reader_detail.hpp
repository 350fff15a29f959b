#pragma once
// Private to core/io: reads HDF5 files of any writer, with no library: files in the forms of all releases, except for
// chunked arrays of the form that 1.10 brought, and for filters other than deflate, shuffle and Fletcher's checksum.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/hdf5/hdf5_objects_detail.hpp"

namespace tetloom::detail {

/// Objects have absolute paths; links that are soft or lead to other files are not there. Errors: InputUnreadable with
/// the path where something is missing or damaged, InputUnsuitable where an array has a form that is not read.
class Hdf5Reader {
 public:
  explicit Hdf5Reader(const InputFile& file) : objects_(file) {}

  bool has(const std::string& path) { return find(path) != nullptr; }
  /// The members of a group in the order in which they were made, by name where that is not known; none without one.
  std::vector<std::string> names_in(const std::string& group);
  bool has_attribute(const std::string& object, std::string_view name);
  std::int64_t attribute(const std::string& object, std::string_view name);
  /// Without white space and zeros at the end; empty where there is none.
  std::string text_attribute(const std::string& object, std::string_view name);

  std::vector<std::uint64_t> shape(const std::string& path);
  std::vector<std::int64_t> integers(const std::string& path);
  std::vector<double> reals(const std::string& path);
  /// In fields of any number of bytes.
  std::vector<std::string> texts(const std::string& path);

 private:
  struct Values {
    Hdf5Datatype type;
    std::uint64_t count = 0;
    std::string owned;         ///< of an array in chunks
    std::string_view in_file;  ///< of others
    std::string_view bytes() const { return owned.empty() ? in_file : std::string_view(owned); }
  };

  const Hdf5Object* find(const std::string& path);
  const Hdf5Object& require(const std::string& path);
  Values read(const std::string& path);
  [[noreturn]] void fail(ErrorCode code, const std::string& path, const std::string& what) const;

  Hdf5Objects objects_;
};

}  // namespace tetloom::detail

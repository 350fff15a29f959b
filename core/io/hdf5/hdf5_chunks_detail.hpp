#pragma once
// Private to core/io: arrays in chunks.
#include <cstdint>
#include <span>
#include <string>

#include "core/io/hdf5/hdf5_objects_detail.hpp"

namespace tetloom::detail {

/// The bytes of an array of `bytes` bytes in chunks, in C order; zeros where no chunk lies. Throws
/// Error(InputUnreadable) for damaged ones, Error(InputUnsuitable) for filters that are not known.
std::string read_hdf5_chunks(Hdf5Objects& objects, const Hdf5Array& array, std::span<const std::uint64_t> shape,
                             std::uint64_t bytes);

}  // namespace tetloom::detail

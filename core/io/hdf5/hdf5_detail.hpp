#pragma once
// Private to core/io: numbers of the HDF5 file format 3.0 that the reader and the writer share.
#include <cstdint>
#include <string_view>

namespace tetloom::detail {

inline constexpr std::string_view kHdf5Signature = "\x89HDF\r\n\x1a\n";
inline constexpr std::uint64_t kHdf5NoAddress = ~std::uint64_t{0};
/// Trees and nested objects that are deeper are taken for damaged.
inline constexpr int kHdf5MostLevels = 64;

/// Types of messages in object headers.
using Hdf5Message = std::uint16_t;
inline constexpr Hdf5Message kHdf5Dataspace = 0x01;
inline constexpr Hdf5Message kHdf5LinkInfo = 0x02;
inline constexpr Hdf5Message kHdf5Datatype = 0x03;
inline constexpr Hdf5Message kHdf5FillValue = 0x05;
inline constexpr Hdf5Message kHdf5Link = 0x06;
inline constexpr Hdf5Message kHdf5ExternalFiles = 0x07;
inline constexpr Hdf5Message kHdf5Layout = 0x08;
inline constexpr Hdf5Message kHdf5GroupInfo = 0x0a;
inline constexpr Hdf5Message kHdf5Filters = 0x0b;
inline constexpr Hdf5Message kHdf5Attribute = 0x0c;
inline constexpr Hdf5Message kHdf5Continuation = 0x10;
inline constexpr Hdf5Message kHdf5SymbolTable = 0x11;
inline constexpr Hdf5Message kHdf5AttributeInfo = 0x15;

/// Classes of datatypes.
enum class Hdf5Class : std::uint8_t { Integer = 0, Real = 1, String = 3, Other = 15 };

/// The checksum of metadata: lookup3 of Bob Jenkins (2006), in its little-endian form, from 0.
std::uint32_t hdf5_checksum(std::string_view bytes);

}  // namespace tetloom::detail

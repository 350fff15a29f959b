#include "core/sizing/memory_check.hpp"

#include <sstream>
#include <string>

#include "core/sizing/memory_limits.hpp"
#include "tetloom/error.hpp"

namespace tetloom {

namespace {

std::string in_gigabytes(double bytes) {
  std::ostringstream text;
  text.precision(3);
  text << bytes / 1e9 << " GB";
  return text.str();
}

}  // namespace

std::uint64_t available_memory() {
  const std::uint64_t bytes = memory_limits().for_each_of(1);
  return bytes == MemoryLimits::kUnlimited ? 0 : bytes;
}

void check_memory(const MeshEstimate& estimate, std::uint64_t max_memory) {
  const std::uint64_t limit = max_memory > 0 ? max_memory : available_memory();
  if (limit == 0 || estimate.bytes <= static_cast<double>(limit)) return;
  std::ostringstream message;
  message.precision(3);
  message << "the mesh would hold about " << estimate.triangles << " triangles";
  if (estimate.tets > 0) message << " and " << estimate.tets << " tetrahedra";
  message << " and need " << in_gigabytes(estimate.bytes) << " of memory, but "
          << in_gigabytes(static_cast<double>(limit)) << (max_memory > 0 ? " are allowed" : " are free")
          << "; ask for larger sizes";
  throw Error(ErrorCode::OutOfMemory, message.str());
}

}  // namespace tetloom

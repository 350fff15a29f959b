// MED in builds without HDF5.
#include "core/io/formats_detail.hpp"
#include "tetloom/error.hpp"

namespace tetloom::detail {
namespace {

[[noreturn]] void refuse() {
  throw Error(ErrorCode::InvalidArgument, "MED files need a tetloom that was built with HDF5 (TETLOOM_MED=ON)");
}

}  // namespace

void write_med(const Mesh&, AtomicFile&, const BlockLoop&) { refuse(); }
Mesh read_med(const InputFile&) { refuse(); }

}  // namespace tetloom::detail

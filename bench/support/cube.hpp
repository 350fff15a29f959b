#pragma once
// The mesh that adaptation begins with.
#include <filesystem>

#include "bench/support/session.hpp"

namespace tetloom::bench {

/// About 10 thousand tets in the unit cube, as MEDIT file in the session's folder, by the command. Throws
/// std::runtime_error.
std::filesystem::path make_cube(const Session& session);

}  // namespace tetloom::bench

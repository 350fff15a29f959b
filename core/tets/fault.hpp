#pragma once
// Why a set of tetrahedra is no mesh, or does not fit its surface.
#include <cstdint>
#include <string>
#include <vector>

#include "tetloom/error.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::tets {

/// What is wrong; empty message: nothing.
struct Fault {
  std::string message;
  std::vector<std::uint32_t> triangles;  ///< of the surface, where they are the trouble
  Vec3 point;
  ErrorCode code = ErrorCode::VolumeFailed;
  bool any() const { return !message.empty(); }
};

}  // namespace tetloom::tets

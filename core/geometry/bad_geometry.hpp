#pragma once
// Entities of a model whose geometry refuses to answer.
#include "tetloom/error.hpp"

namespace tetloom {

/// Runs `body`, which asks one entity for its geometry. What that refuses is left to whoever meshes the entity to
/// report: sizes and metrics can do without it. Errors: Cancelled and OutOfMemory pass.
template <class Body>
void tolerate_bad_geometry(const Body& body) {
  try {
    body();
  } catch (const Error& error) {
    if (error.code() == ErrorCode::Cancelled || error.code() == ErrorCode::OutOfMemory) throw;
  }
}

}  // namespace tetloom

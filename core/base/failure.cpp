#include "core/base/failure.hpp"

#include <exception>
#include <new>

namespace tetloom {

std::optional<Diagnostic> failure_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.diagnostic();
  } catch (const std::bad_alloc&) {
    return Diagnostic{ErrorCode::OutOfMemory, "the memory is exhausted", {}, {}, {}};
  } catch (const std::exception& error) {
    return Diagnostic{ErrorCode::Internal, std::string("unexpected error: ") + error.what(), {}, {}, {}};
  } catch (...) {
    return Diagnostic{ErrorCode::Internal, "unexpected error of an unknown type", {}, {}, {}};
  }
  return std::nullopt;
}

}  // namespace tetloom

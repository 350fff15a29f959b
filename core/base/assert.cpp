#include "core/base/assert.hpp"

#include <string>

#include "core/base/error.hpp"

namespace tetloom::detail {

void fail_assertion(const char* condition, const char* file, int line) {
  throw Error(ErrorCode::Internal,
              std::string("broken invariant: ") + condition + " (" + file + ":" + std::to_string(line) + ")");
}

}  // namespace tetloom::detail

#include "tetloom/assert.hpp"

#include <string>

#include "tetloom/error.hpp"

namespace tetloom::detail {

void fail_assertion(const char* condition, const char* file, int line) {
  throw Error(ErrorCode::Internal,
              std::string("broken invariant: ") + condition + " (" + file + ":" + std::to_string(line) + ")");
}

}  // namespace tetloom::detail

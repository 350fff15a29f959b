#pragma once
// The commit that a bench was built from; its definition is written at every build.

namespace tetloom::bench {

/// As `git describe --always --dirty` says, or "unknown".
extern const char* const kCommit;

}  // namespace tetloom::bench

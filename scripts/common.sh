# Sourced by the other scripts: they run from the root of the checkout, whatever folder they are called from.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '\n== %s\n' "$*"; }

jobs=${TETLOOM_JOBS:-$(nproc)}

# configure_and_build PRESET [TARGET…]: into build/PRESET.
configure_and_build() {
  local preset=$1
  shift
  cmake --preset "$preset" >"/tmp/tetloom-configure.$$" || {
    cat "/tmp/tetloom-configure.$$" >&2
    rm -f "/tmp/tetloom-configure.$$"
    return 1
  }
  rm -f "/tmp/tetloom-configure.$$"
  cmake --build --preset "$preset" --parallel "$jobs" ${1:+--target "$@"}
}

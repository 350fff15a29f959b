# Sourced by the examples' run.sh: their arguments, what they need, and tetloom's programs.
source "$(dirname "${BASH_SOURCE[0]}")/../scripts/common.sh"

# take_arguments NAME [--quick] [--bin FOLDER] [FOLDER]: sets here, quick, bin and folder.
take_arguments() {
  here=examples/$1 folder=out/$1 bin= quick=
  shift
  while [[ "${1:-}" == --* ]]; do
    case "$1" in
      --quick) quick=--quick ;;
      --bin) bin=$2; shift ;;
      *) sed -n '2,/^source/{/^#/s/^# \{0,1\}//p}' "$here/run.sh" >&2; exit 2 ;;
    esac
    shift
  done
  folder=${1:-$folder}
  mkdir -p "$folder"
}

# skip WHAT GROUP: ends with status 77, which tests take for skipped.
skip() {
  echo "run.sh: $1 is not installed; run scripts/install-deps.sh $2" >&2
  exit 77
}

# need_modules GROUP MODULE…: of Debian's Python.
need_modules() {
  local group=$1 module
  shift
  for module in "$@"; do
    /usr/bin/python3 -c "import $module" 2>/dev/null || skip "the Python module $module" "$group"
  done
}

# Where --bin did not say where they are.
build_programs() {
  [[ -z "$bin" ]] || return 0
  say "Building (preset release)"
  configure_and_build release tetloom tetloom-tetgen tetloom-demo-model
  bin=build/release/bin
}

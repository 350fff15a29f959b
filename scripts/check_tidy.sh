#!/usr/bin/env bash
# Checks names (see .clang-tidy) in every source, or in the given ones, with the flags of a build folder.
#
# usage: scripts/check_tidy.sh [-p BUILD] [FILE…]
#   BUILD   folder with compile_commands.json; default: the first that exists of build/release, build/asan-ubsan,
#           build/debug; it is configured when there is none
source "$(dirname "$0")/common.sh"

build=
if [[ "${1:-}" == -p ]]; then
  build=$2
  shift 2
fi
tidy=$(command -v clang-tidy-14 || command -v clang-tidy) || {
  echo "check_tidy.sh: clang-tidy 14 is not installed; run scripts/install-deps.sh check" >&2
  exit 1
}
for candidate in build/release build/asan-ubsan build/debug; do
  [[ -n "$build" || ! -f "$candidate/compile_commands.json" ]] || build=$candidate
done
if [[ -z "$build" ]]; then
  cmake --preset release >/dev/null
  build=build/release
fi
if [[ $# -gt 0 ]]; then
  sources=("$@")
else
  mapfile -t sources < <(python3 - "$build" <<'PY'
import json, os, sys
root = os.getcwd() + "/"
files = {c["file"] for c in json.load(open(sys.argv[1] + "/compile_commands.json"))}
print("\n".join(sorted(f[len(root):] for f in files if f.startswith(root) and not f.startswith(root + "build/"))))
PY
)
fi
[[ ${#sources[@]} -gt 0 ]] || { echo "check_tidy.sh: no sources" >&2; exit 1; }

log=$(mktemp)
trap 'rm -f "$log"' EXIT
status=0
# Each finding in a header shows up once per source that includes it: the log is made unique below.
printf '%s\0' "${sources[@]}" |
  xargs -0 --max-args 1 --max-procs "$jobs" "$tidy" -p "$build" --quiet --extra-arg=-Wno-everything \
    >"$log" 2>/dev/null || status=$?
grep -E '(warning|error): ' "$log" | sort --unique || true
[[ $status -eq 0 ]] || { echo "check_tidy.sh: names differ from .clang-tidy" >&2; exit 1; }
echo "${#sources[@]} sources: all names are as .clang-tidy says."

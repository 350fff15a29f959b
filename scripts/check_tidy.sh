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
# Only names are judged here. clang 14 cannot parse all of C++20 (a lambda that captures a structured binding, say) and
# exits with an error then, but it still goes on to check names: so findings are counted and not exit statuses. Each
# finding in a header shows up once per source that includes it, hence `sort --unique`.
printf '%s\0' "${sources[@]}" |
  xargs -0 --max-args 1 --max-procs "$jobs" "$tidy" -p "$build" --quiet --extra-arg=-Wno-everything >"$log" 2>/dev/null ||
  true
findings=$(grep -F '[readability-identifier-naming' "$log" | grep -v '^error: ' | sort --unique || true)
if [[ -n "$findings" ]]; then
  printf '%s\n' "$findings" >&2
  echo "check_tidy.sh: names differ from .clang-tidy" >&2
  exit 1
fi
if grep -qE 'no input files|file not found|unable to handle compilation' "$log"; then
  grep -E 'no input files|file not found|unable to handle compilation' "$log" | sort --unique >&2
  echo "check_tidy.sh: $build/compile_commands.json does not fit the sources; build the preset again" >&2
  exit 1
fi
echo "${#sources[@]} sources: all names are as .clang-tidy says."

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
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
log=$folder/log
# Most of the time goes into headers, so sources of the same flags are read by dozens: one file that includes them all.
python3 - "$build" "$folder" "$@" <<'PY'
import json, os, re, sys
build, folder, named = sys.argv[1], sys.argv[2], sys.argv[3:]
root = os.getcwd() + "/"
groups, seen = {}, set()
for command in json.load(open(build + "/compile_commands.json")):
    name = command["file"]
    short = name.removeprefix(root)
    if short in seen or not name.startswith(root) or short.startswith("build/") or (named and short not in named):
        continue
    seen.add(short)
    # Precompiled headers of another compiler cannot be read; sources include what they need anyway.
    text = re.sub(r" -o \S+ -c .*| -Winvalid-pch| -include \S+cmake_pch\.hxx", "", command["command"])
    groups.setdefault((text, command["directory"], os.path.dirname(short)), []).append(name)
batches = []
for (text, directory, _), names in groups.items():
    for begin in range(0, len(names), 12):
        path = f"{folder}/batch_{len(batches)}.cpp"
        with open(path, "w") as batch:
            batch.writelines(f'#include "{name}"\n' for name in names[begin:begin + 12])
        batches.append({"file": path, "directory": directory, "command": f"{text} -c {path}"})
json.dump(batches, open(folder + "/compile_commands.json", "w"))
open(folder + "/count", "w").write(str(len(seen)))
PY
count=$(<"$folder/count")
[[ $count -gt 0 ]] || { echo "check_tidy.sh: no sources" >&2; exit 1; }

# Only names are judged here. clang 14 cannot parse all of C++20 (a lambda that captures a structured binding, say), and
# sources in one file may have private names in common; clang exits with an error then, but it still goes on to check
# names: so findings are counted and not exit statuses. Each finding in a header shows up more than once, hence
# `sort --unique`.
filter="$PWD/(include|core|threading|mesher|adapt|apps|examples|bench|tests)/.*"
printf '%s\0' "$folder"/batch_*.cpp |
  xargs -0 --max-args 1 --max-procs "$jobs" "$tidy" -p "$folder" --config-file="$PWD/.clang-tidy" --quiet --header-filter="$filter" \
        --extra-arg=-Wno-everything --extra-arg=-ferror-limit=0 >"$log" 2>/dev/null ||
  true
findings=$(grep -F '[readability-identifier-naming' "$log" | grep -v '^error: ' | sort --unique || true)
if [[ -n "$findings" ]]; then
  printf '%s\n' "$findings" >&2
  echo "check_tidy.sh: names differ from .clang-tidy" >&2
  exit 1
fi
if grep -qE 'no input files|file not found|unable to handle compilation|PCH file' "$log"; then
  grep -E 'no input files|file not found|unable to handle compilation|PCH file' "$log" | sort --unique >&2
  echo "check_tidy.sh: $build/compile_commands.json does not fit the sources; build the preset again" >&2
  exit 1
fi
echo "$count sources: all names are as .clang-tidy says."

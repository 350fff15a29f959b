#!/usr/bin/env bash
# Checks that every C++ source is formatted as .clang-format says; with --fix, formats it.
#
# usage: scripts/check_format.sh [--fix]
source "$(dirname "$0")/common.sh"

mode=(--dry-run -Werror)
[[ "${1:-}" == --fix ]] && mode=(-i)
formatter=$(command -v clang-format-14 || command -v clang-format) || {
  echo "check_format.sh: clang-format 14 is not installed; run scripts/install-deps.sh check" >&2
  exit 1
}
mapfile -t sources < <(git ls-files --cached --others --exclude-standard -- '*.cpp' '*.hpp')
printf '%s\n' "${sources[@]}" | xargs --max-args 20 --max-procs "$jobs" "$formatter" "${mode[@]}"
echo "${#sources[@]} files are formatted as .clang-format says."

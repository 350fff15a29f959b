#!/usr/bin/env bash
# Programs of others read the files that tetloom writes, in every format and both orders: do they find the counts, the
# volumes and the names? Prints a line for each, ends with status 1 where one did not.
#
# usage: scripts/check_readers.sh [--bin FOLDER] [--out FOLDER] [MODEL…]     default: two demo models, out/readers
# Readers that are not installed are left out; `scripts/install-deps.sh readers` installs all of them.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

bin= folder=out/readers
while [[ "${1:-}" == --* ]]; do
  case "$1" in
    --bin) bin=$2; shift ;;
    --out) folder=$2; shift ;;
    *) sed -n '2,/^source/{/^#/s/^# \{0,1\}//p}' scripts/check_readers.sh >&2; exit 2 ;;
  esac
  shift
done
if [[ -z "$bin" ]]; then
  say "Building (preset release)"
  configure_and_build release tetloom tetloom-tetgen tetloom-demo-model
  bin=build/release/bin
fi
environment=/usr/share/openfoam/etc/bashrc
if [[ -z "${WM_PROJECT_DIR:-}" && -r "$environment" ]]; then
  set +eu  # it is not written for them
  source "$environment" >/dev/null 2>&1
  set -eu
fi
mkdir -p "$folder"
models=("$@")
if [[ ${#models[@]} == 0 ]]; then
  "$bin/tetloom-demo-model" machined-part "$folder/part.step"
  "$bin/tetloom-demo-model" manifold "$folder/manifold.step" 3
  models=("$folder/part.step" "$folder/manifold.step")
fi
/usr/bin/python3 scripts/check_readers.py --tetloom "$bin/tetloom" --folder "$folder" "${models[@]}"

#!/usr/bin/env bash
# The adaptive loop: FreeFEM solves, tetloom adapts the mesh and carries the solution over, ten times; beside it the same
# on uniform meshes. Prints a table and draws it.
#
# usage: examples/adaptive_loop/run.sh [--quick] [--bin FOLDER] [FOLDER]      default: out/adaptive_loop
#   --quick   two cycles on one small mesh, only to see that it works
#   --bin     tetloom's programs lie there; else they are built (preset release)
# Ends with status 77 where FreeFEM or numpy are not installed (scripts/install-deps.sh freefem).
source "$(dirname "${BASH_SOURCE[0]}")/../../scripts/common.sh"

here=examples/adaptive_loop
bin= quick=
while [[ "${1:-}" == --* ]]; do
  case "$1" in
    --quick) quick=1 ;;
    --bin) bin=$2; shift ;;
    *) sed -n '2,/^source/{/^#/s/^# \{0,1\}//p}' "$here/run.sh" >&2; exit 2 ;;
  esac
  shift
done
folder=${1:-out/adaptive_loop}

freefem=$(command -v FreeFem++-nw || command -v FreeFem++) || {
  echo "run.sh: FreeFEM is not installed, so there is nothing that solves; run scripts/install-deps.sh freefem" >&2
  exit 77
}
/usr/bin/python3 -c 'import numpy' 2>/dev/null || {
  echo "run.sh: numpy is not installed for /usr/bin/python3; run scripts/install-deps.sh freefem" >&2
  exit 77
}
if [[ -z "$bin" ]]; then
  say "Building (preset release)"
  configure_and_build release tetloom tetloom-tetgen tetloom-demo-model
  bin=build/release/bin
fi

mkdir -p "$folder"
"$bin/tetloom-demo-model" machined-part "$folder/part.step"
loop=("$here/adaptive_loop.py" --tetloom "$bin/tetloom" --freefem "$freefem" --model "$folder/part.step" --folder "$folder")
say "Solving and adapting"
if [[ -n "$quick" ]]; then
  "${loop[@]}" --cycles 2 --complexities 300
else
  "${loop[@]}" --plot "$folder/adaptive_loop.svg"
  echo "In $(realpath "$folder"): adaptive_loop.svg, and adapted.mesh, the last of the finest meshes"
fi

#!/usr/bin/env bash
# The adaptive loop: FreeFEM solves, tetloom adapts the mesh and carries the solution over, ten times; beside it the same
# on uniform meshes. Prints a table and draws it.
#
# usage: examples/adaptive_loop/run.sh [--quick] [--bin FOLDER] [FOLDER]      default: out/adaptive_loop
#   --quick   two cycles on one small mesh, only to see that it works
#   --bin     tetloom's programs lie there; else they are built (preset release)
# Ends with status 77 where FreeFEM or numpy are not installed (scripts/install-deps.sh freefem).
source "$(dirname "${BASH_SOURCE[0]}")/../example.sh"

take_arguments adaptive_loop "$@"
freefem=$(command -v FreeFem++-nw || command -v FreeFem++) || skip FreeFEM freefem
need_modules freefem numpy
build_programs

"$bin/tetloom-demo-model" machined-part "$folder/part.step"
loop=("$here/adaptive_loop.py" --tetloom "$bin/tetloom" --freefem "$freefem" --model "$folder/part.step" --folder "$folder")
say "Solving and adapting"
if [[ -n "$quick" ]]; then
  "${loop[@]}" --cycles 2 --complexities 300
else
  "${loop[@]}" --plot "$folder/adaptive_loop.svg"
  echo "In $(realpath "$folder"): adaptive_loop.svg, and adapted.mesh, the last of the finest meshes"
fi

#!/usr/bin/env bash
# CalculiX on meshes of first and second order: a ball and a hollow sphere whose stresses are known, and a bracket with
# named supports and load. Prints tables and draws them.
#
# usage: examples/calculix/run.sh [--quick] [--bin FOLDER] [FOLDER]      default: out/calculix
#   --quick   coarse meshes, only to see that it works
#   --bin     tetloom's programs lie there; else they are built (preset release)
# Ends with status 77 where CalculiX or numpy are not installed (scripts/install-deps.sh calculix).
source "$(dirname "${BASH_SOURCE[0]}")/../example.sh"

take_arguments calculix "$@"
solver=$(command -v ccx) || skip CalculiX calculix
need_modules calculix numpy
build_programs

"$bin/tetloom-demo-model" ball "$folder/ball.step" 10
"$bin/tetloom-demo-model" hollow-sphere "$folder/shell.step"
"$bin/tetloom-demo-model" machined-part "$folder/part.step"
say "Meshing and solving"
"$here/calculix.py" --tetloom "$bin/tetloom" --solver "$solver" --folder "$folder" $quick
[[ -n "$quick" ]] || echo "In $(realpath "$folder"): shell.svg and bracket.svg"

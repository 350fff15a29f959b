#!/usr/bin/env bash
# dolfinx on meshes of first and second order of a hollow sphere: the heat that flows through it, which is known.
#
# usage: examples/dolfinx/run.sh [--quick] [--bin FOLDER] [FOLDER]      default: out/dolfinx
#   --quick   coarse meshes, only to see that it works
#   --bin     tetloom's programs lie there; else they are built (preset release)
# Ends with status 77 where dolfinx or meshio are not installed (scripts/install-deps.sh dolfinx).
source "$(dirname "${BASH_SOURCE[0]}")/../example.sh"

take_arguments dolfinx "$@"
need_modules dolfinx dolfinx meshio
build_programs

"$bin/tetloom-demo-model" hollow-sphere "$folder/shell.step"
say "Meshing and solving"
"$here/dolfinx_shell.py" --tetloom "$bin/tetloom" --folder "$folder" $quick
[[ -n "$quick" ]] || echo "In $(realpath "$folder"): dolfinx.svg"

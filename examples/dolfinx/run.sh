#!/usr/bin/env bash
# dolfinx on meshes of first and second order of a hollow sphere: the heat that flows through it, which is known.
#
# usage: examples/dolfinx/run.sh [--quick] [--bin FOLDER] [FOLDER]      default: out/dolfinx
#   --quick   coarse meshes, only to see that it works
#   --bin     tetloom's programs lie there; else they are built (preset release)
# Ends with status 77 where dolfinx or meshio are not installed (scripts/install-deps.sh dolfinx).
source "$(dirname "${BASH_SOURCE[0]}")/../../scripts/common.sh"

here=examples/dolfinx
bin= quick=
while [[ "${1:-}" == --* ]]; do
  case "$1" in
    --quick) quick=--quick ;;
    --bin) bin=$2; shift ;;
    *) sed -n '2,/^source/{/^#/s/^# \{0,1\}//p}' "$here/run.sh" >&2; exit 2 ;;
  esac
  shift
done
folder=${1:-out/dolfinx}

/usr/bin/python3 -c 'import dolfinx, meshio' 2>/dev/null || {
  echo "run.sh: dolfinx or meshio is not installed, so there is nothing that solves; run scripts/install-deps.sh dolfinx" >&2
  exit 77
}
if [[ -z "$bin" ]]; then
  say "Building (preset release)"
  configure_and_build release tetloom tetloom-tetgen tetloom-demo-model
  bin=build/release/bin
fi

mkdir -p "$folder"
"$bin/tetloom-demo-model" hollow-sphere "$folder/shell.step"
say "Meshing and solving"
"$here/dolfinx_shell.py" --tetloom "$bin/tetloom" --folder "$folder" $quick
[[ -n "$quick" ]] || echo "In $(realpath "$folder"): dolfinx.svg"

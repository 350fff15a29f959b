#!/usr/bin/env bash
# CalculiX on meshes of first and second order: a ball and a hollow sphere whose stresses are known, and a bracket with
# named supports and load. Prints tables and draws them.
#
# usage: examples/calculix/run.sh [--quick] [--bin FOLDER] [FOLDER]      default: out/calculix
#   --quick   coarse meshes, only to see that it works
#   --bin     tetloom's programs lie there; else they are built (preset release)
# Ends with status 77 where CalculiX or numpy are not installed (scripts/install-deps.sh calculix).
source "$(dirname "${BASH_SOURCE[0]}")/../../scripts/common.sh"

here=examples/calculix
bin= quick=
while [[ "${1:-}" == --* ]]; do
  case "$1" in
    --quick) quick=--quick ;;
    --bin) bin=$2; shift ;;
    *) sed -n '2,/^source/{/^#/s/^# \{0,1\}//p}' "$here/run.sh" >&2; exit 2 ;;
  esac
  shift
done
folder=${1:-out/calculix}

solver=$(command -v ccx) || {
  echo "run.sh: CalculiX is not installed, so there is nothing that solves; run scripts/install-deps.sh calculix" >&2
  exit 77
}
/usr/bin/python3 -c 'import numpy' 2>/dev/null || {
  echo "run.sh: numpy is not installed for /usr/bin/python3; run scripts/install-deps.sh calculix" >&2
  exit 77
}
if [[ -z "$bin" ]]; then
  say "Building (preset release)"
  configure_and_build release tetloom tetloom-tetgen tetloom-demo-model
  bin=build/release/bin
fi

mkdir -p "$folder"
"$bin/tetloom-demo-model" ball "$folder/ball.step" 10
"$bin/tetloom-demo-model" hollow-sphere "$folder/shell.step"
"$bin/tetloom-demo-model" machined-part "$folder/part.step"
say "Meshing and solving"
"$here/calculix.py" --tetloom "$bin/tetloom" --solver "$solver" --folder "$folder" $quick
[[ -n "$quick" ]] || echo "In $(realpath "$folder"): shell.svg and bracket.svg"

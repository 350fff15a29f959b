#!/usr/bin/env bash
# OpenFOAM on meshes that tetloom writes as its cases: the flow in a pipe, of which the drop of pressure is known, and in
# a manifold with named ends.
#
# usage: examples/openfoam/run.sh [--quick] [--bin FOLDER] [FOLDER]      default: out/openfoam
#   --quick   coarse meshes, only to see that it works
#   --bin     tetloom's programs lie there; else they are built (preset release)
# Ends with status 77 where OpenFOAM or numpy are not installed (scripts/install-deps.sh openfoam).
source "$(dirname "${BASH_SOURCE[0]}")/../../scripts/common.sh"

here=examples/openfoam
bin= quick=
while [[ "${1:-}" == --* ]]; do
  case "$1" in
    --quick) quick=--quick ;;
    --bin) bin=$2; shift ;;
    *) sed -n '2,/^source/{/^#/s/^# \{0,1\}//p}' "$here/run.sh" >&2; exit 2 ;;
  esac
  shift
done
folder=${1:-out/openfoam}

environment=/usr/share/openfoam/etc/bashrc
if [[ -z "${WM_PROJECT_DIR:-}" && -r "$environment" ]]; then
  set +eu  # it is not written for them
  source "$environment" >/dev/null 2>&1
  set -eu
fi
command -v simpleFoam >/dev/null || {
  echo "run.sh: OpenFOAM is not installed, so there is nothing that solves; run scripts/install-deps.sh openfoam" >&2
  exit 77
}
/usr/bin/python3 -c 'import numpy' 2>/dev/null || {
  echo "run.sh: numpy is not installed for /usr/bin/python3; run scripts/install-deps.sh openfoam" >&2
  exit 77
}
if [[ -z "$bin" ]]; then
  say "Building (preset release)"
  configure_and_build release tetloom tetloom-tetgen tetloom-demo-model
  bin=build/release/bin
fi

mkdir -p "$folder"
"$bin/tetloom-demo-model" manifold "$folder/pipe.step" 0
"$bin/tetloom-demo-model" manifold "$folder/manifold.step" 3
say "Meshing and solving"
"$here/openfoam.py" --tetloom "$bin/tetloom" --folder "$folder" $quick

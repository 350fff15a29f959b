#!/usr/bin/env bash
# OpenFOAM on meshes that tetloom writes as its cases: the flow in a pipe, of which the drop of pressure is known, and in
# a manifold with named ends.
#
# usage: examples/openfoam/run.sh [--quick] [--bin FOLDER] [FOLDER]      default: out/openfoam
#   --quick   coarse meshes, only to see that it works
#   --bin     tetloom's programs lie there; else they are built (preset release)
# Ends with status 77 where OpenFOAM or numpy are not installed (scripts/install-deps.sh openfoam).
source "$(dirname "${BASH_SOURCE[0]}")/../example.sh"

take_arguments openfoam "$@"
environment=/usr/share/openfoam/etc/bashrc
if [[ -z "${WM_PROJECT_DIR:-}" && -r "$environment" ]]; then
  set +eu  # it is not written for them
  source "$environment" >/dev/null 2>&1
  set -eu
fi
command -v simpleFoam >/dev/null || skip OpenFOAM openfoam
need_modules openfoam numpy
build_programs

"$bin/tetloom-demo-model" manifold "$folder/pipe.step" 0
"$bin/tetloom-demo-model" manifold "$folder/manifold.step" 3
say "Meshing and solving"
"$here/openfoam.py" --tetloom "$bin/tetloom" --folder "$folder" $quick

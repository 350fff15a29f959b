#!/usr/bin/env bash
# Installs tetloom into an empty folder, builds examples/host against that alone, outside the build tree, and runs it.
# usage: install_test.sh BUILD SOURCE DEMO_MODEL
set -euo pipefail

build=$1 source=$2 demo_model=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() {
  echo "install test: $*" >&2
  exit 1
}

cmake --install "$build" --prefix "$work/prefix" >"$work/install.log" || { cat "$work/install.log"; fail "cannot install"; }
# The example is copied: nothing of the checkout may be reached through relative paths.
cp -r "$source/examples/host" "$work/source"
launcher=()
command -v ccache >/dev/null && launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
cmake -S "$work/source" -B "$work/host" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$work/prefix" \
  "${launcher[@]}"
cmake --build "$work/host"

"$demo_model" assembly "$work/assembly.step"
"$work/host/tetloom-host" "$work/assembly.step" "$work/out.vtu" >"$work/out.txt" 2>"$work/progress.txt"
grep -q 'tetrahedra written' "$work/out.txt" || fail "the host wrote no mesh"
grep -q 'faces' "$work/progress.txt" || fail "the host saw no progress"
"$work/prefix/bin/tetloom" check "$work/out.vtu" --quiet || fail "the host's mesh is not valid"

status=0
"$work/host/tetloom-host" "$work/assembly.step" "$work/stopped.vtu" 0.02 >"$work/stopped.txt" 2>/dev/null || status=$?
[[ $status -eq 5 ]] || fail "the host could not stop the work: exit status $status"
grep -q '^cancelled' "$work/stopped.txt" || fail "the host was not told that the work was cancelled"
[[ ! -e "$work/stopped.vtu" ]] || fail "a cancelled run left a mesh"

# The installed command works from its new place, and finds its worker there.
cd "$work"
env -i PATH=/nowhere "$work/prefix/bin/tetloom" mesh assembly.step -o installed.vtu --size 8 --quiet ||
  fail "the installed command does not work"
[[ ! -e "$work/prefix/include/tetloom/core/cad/detail" ]] || fail "private headers were installed"
echo "installed, built and run outside the build tree"

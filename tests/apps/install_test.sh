#!/usr/bin/env bash
# Installs tetloom into an empty folder, compiles every installed header alone, builds examples/host against that
# alone, outside the build tree, and runs it: it meshes, adapts and partitions.
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
# Nothing but public headers, and few of them; each compiles alone.
headers=$work/prefix/include
[[ $(ls "$headers") == tetloom ]] || fail "something beside tetloom/ in the include folder: $(ls "$headers")"
[[ -z $(find "$headers/tetloom" -mindepth 1 ! -name '*.hpp') ]] || fail "something beside headers was installed"
count=$(find "$headers/tetloom" -name '*.hpp' | wc -l)
((count >= 5 && count <= 20)) || fail "$count headers were installed"
for name in adapt io mesh model partition; do
  [[ -e $headers/tetloom/$name.hpp ]] || fail "<tetloom/$name.hpp> was not installed"
done
for header in "$headers"/tetloom/*.hpp; do
  printf '#include <tetloom/%s>\n' "$(basename "$header")" >"$work/alone.cpp"
  "${CXX:-c++}" -std=c++20 -Wall -Wextra -Werror -I "$headers" -fsyntax-only "$work/alone.cpp" ||
    fail "$(basename "$header") does not compile alone"
done

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

"$work/host/tetloom-host-parts" "$work/assembly.step" "$work/parts.pvtu" 6 >"$work/parts.txt" ||
  fail "the host in parts failed"
grep -q 'cells in 6 parts' "$work/parts.txt" || fail "the host did not deal its mesh"
grep -q 'cells adapted, in 6 parts' "$work/parts.txt" || fail "the host did not adapt its mesh"
"$work/prefix/bin/tetloom" check "$work/parts.pvtu" --quiet || fail "the host's parts are not valid"

status=0
"$work/host/tetloom-host" "$work/assembly.step" "$work/stopped.vtu" 0.02 >"$work/stopped.txt" 2>/dev/null || status=$?
[[ $status -eq 5 ]] || fail "the host could not stop the work: exit status $status"
grep -q '^cancelled' "$work/stopped.txt" || fail "the host was not told that the work was cancelled"
[[ ! -e "$work/stopped.vtu" ]] || fail "a cancelled run left a mesh"

# The installed command works from its new place, and finds its worker there.
cd "$work"
env -i PATH=/nowhere "$work/prefix/bin/tetloom" mesh assembly.step -o installed.vtu --size 8 --quiet ||
  fail "the installed command does not work"
echo "installed, built and run outside the build tree"

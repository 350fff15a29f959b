#!/usr/bin/env bash
# Builds oneTBB from its Debian source package with the thread sanitizer, into a cached folder that the `tsan` preset
# uses. The packaged oneTBB is not instrumented and gives spurious reports.
#
# usage: scripts/build_tsan_tbb.sh      prints the folder of the CMake package; builds nothing when it is there already
#   TETLOOM_CACHE   where it is kept; default: ~/.cache/tetloom
source "$(dirname "$0")/common.sh"

cache=${TETLOOM_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/tetloom}
version=$(dpkg-query --show --showformat='${source:Version}' libtbb-dev)
prefix=$cache/tsan-tbb-${version//[^0-9A-Za-z.+-]/_}
package=$prefix/lib/cmake/TBB
if [[ ! -f "$package/TBBConfig.cmake" ]]; then
  ./scripts/install-deps.sh build tsan >&2
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
  # Source packages are fetched through a private copy of apt's lists: the system's configuration stays as it is.
  mkdir -p "$work/lists/partial" "$work/cache/archives/partial" "$work/source"
  . /etc/os-release
  for suite in "$VERSION_CODENAME" "$VERSION_CODENAME-updates"; do
    echo "deb-src http://deb.debian.org/debian $suite main"
  done >"$work/sources.list"
  apt_options=(-o "Dir::Etc::SourceList=$work/sources.list" -o Dir::Etc::SourceParts=/dev/null
    -o "Dir::State::Lists=$work/lists" -o "Dir::Cache=$work/cache" -o "APT::Sandbox::User=$(id -un)")
  apt-get -qq "${apt_options[@]}" update >&2
  (cd "$work/source" && apt-get -qq "${apt_options[@]}" source "onetbb=$version" >&2)
  cmake -S "$work"/source/onetbb-*/ -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_SANITIZE=thread \
    -DTBB_TEST=OFF -DTBBMALLOC_BUILD=OFF -DTBB_STRICT=OFF -DCMAKE_INSTALL_LIBDIR=lib \
    -DCMAKE_INSTALL_PREFIX="$prefix" >&2
  cmake --build "$work/build" --parallel "$jobs" >&2
  cmake --install "$work/build" >&2
fi
echo "$package"

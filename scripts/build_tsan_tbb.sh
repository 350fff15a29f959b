#!/usr/bin/env bash
# Builds oneTBB from its Debian source package with the thread sanitizer, into a cached folder that the `tsan` preset
# uses. The packaged oneTBB is not instrumented and gives spurious reports.
#
# usage: scripts/build_tsan_tbb.sh      prints the folder of the CMake package; builds nothing when it is there already
#   TETLOOM_CACHE   where it is kept; default: ~/.cache/tetloom
source "$(dirname "$0")/common.sh"

cache=$(realpath -m "${TETLOOM_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/tetloom}")
./scripts/install-deps.sh build >&2
version=$(dpkg-query --show --showformat='${source:Version}' libtbb-dev)
prefix=$cache/tsan-tbb-${version//[^0-9A-Za-z.+-]/_}
package=$prefix/lib/cmake/TBB

fail() {
  echo "build_tsan_tbb.sh: $*" >&2
  exit 1
}

# Through a private copy of apt's lists: the system's configuration stays as it is.
fetch_source() {
  mkdir -p "$work/lists/partial" "$work/cache/archives/partial" "$work/source"
  . /etc/os-release
  {
    echo "deb-src http://deb.debian.org/debian $VERSION_CODENAME main"
    echo "deb-src http://deb.debian.org/debian $VERSION_CODENAME-updates main"
    echo "deb-src http://deb.debian.org/debian-security $VERSION_CODENAME-security main"
  } >"$work/sources.list"
  local options=(-o "Dir::Etc::SourceList=$work/sources.list" -o Dir::Etc::SourceParts=/dev/null
    -o "Dir::State::Lists=$work/lists" -o "Dir::Cache=$work/cache" -o "APT::Sandbox::User=$(id -un)")
  apt-get -qq "${options[@]}" update >&2 && cd "$work/source" && apt-get -qq "${options[@]}" source "onetbb=$version" >&2
}

# Into a folder below $work, which is moved in one step: a build that was interrupted leaves nothing that looks whole.
build_and_install() {
  # GCC warns that the sanitizer does not see fences; oneTBB's tasks are synchronised by atomic operations as well.
  cmake -S "$work"/source/onetbb-*/ -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_SANITIZE=thread \
    -DTBB_TEST=OFF -DTBBMALLOC_BUILD=OFF -DTBB_STRICT=OFF -DCMAKE_CXX_FLAGS=-Wno-tsan -DCMAKE_INSTALL_LIBDIR=lib \
    -DCMAKE_INSTALL_PREFIX="$prefix" >&2 &&
    cmake --build "$work/build" --parallel "$jobs" >&2 &&
    DESTDIR=$work/install cmake --install "$work/build" >/dev/null &&
    rm -rf "$prefix" && mv "$work/install$prefix" "$prefix"
}

if [[ ! -f "$package/TBBConfig.cmake" ]]; then
  ./scripts/install-deps.sh tsan >&2
  mkdir -p "$cache"
  work=$(mktemp -d "$cache/tsan-tbb.XXXXXX")
  trap 'rm -rf "$work"' EXIT
  (fetch_source) || fail "cannot fetch the Debian source package onetbb $version from deb.debian.org"
  build_and_install || fail "cannot build oneTBB $version with the thread sanitizer"
fi
echo "$package"

#!/usr/bin/env bash
# Installs the Debian packages that tetloom needs. This is the one list of them: every other script calls this one.
#
# usage: scripts/install-deps.sh [build] [check] [oracles] [picture] [peers] [freefem] [calculix] [openfoam] [dolfinx] [readers] [tsan]
#   build    what configures, compiles and tests tetloom (the default)
#   check    what .ci/run needs beside: formatter, naming checks
#   oracles  libraries that tests compare tetloom with, where they are installed
#   picture  what scripts/draw_mesh.py needs
#   peers    other meshers, run beside tetloom by the benches where they are installed
#   freefem  what examples/adaptive_loop needs: a solver
#   calculix what examples/calculix needs: a solver
#   openfoam what examples/openfoam needs: a solver
#   dolfinx  what examples/dolfinx needs: a solver
#   readers  what scripts/check_readers.sh runs beside solvers: programs and libraries that read meshes
#   tsan     what scripts/build_tsan_tbb.sh needs beside
# Installed packages are left as they are; without missing ones neither the network nor root is needed.
set -euo pipefail

declare -A packages=(
  [build]="g++ cmake ninja-build ccache
    libocct-data-exchange-dev libocct-foundation-dev libocct-modeling-algorithms-dev libocct-modeling-data-dev
    libocct-ocaf-dev libocct-visualization-dev libfontconfig-dev
    libtbb-dev libscotch-dev libtrilinos-zoltan-dev libopenmpi-dev openmpi-bin
    libopenmesh-dev libtet1.5-dev libeigen3-dev zlib1g-dev
    libcli11-dev nlohmann-json3-dev catch2 libbenchmark-dev"
  [check]="git python3 mold clang-format-14 clang-tidy-14"
  [oracles]="libcgal-dev"
  [picture]="python3 python3-numpy python3-meshio python3-pil"
  [peers]="gmsh netgen tetgen"
  [freefem]="freefem++ python3 python3-numpy"
  [calculix]="calculix-ccx python3 python3-numpy"
  [openfoam]="openfoam python3 python3-numpy"
  [dolfinx]="python3-dolfinx python3-meshio"
  [readers]="calculix-ccx cgns-convert code-saturne-bin freefem++ gmsh libexodusii5 libmed-tools openfoam
    python3 python3-getfem python3-h5py python3-meshio python3-netcdf4 python3-numpy python3-vtk9"
  [tsan]="dpkg-dev"
)

fail() {
  echo "install-deps.sh: $*" >&2
  exit 1
}

is_installed() {
  [[ "$(dpkg-query --show --showformat='${db:Status-Status}' "$1" 2>/dev/null)" == installed ]]
}

missing_packages() {
  local group package
  for group in "$@"; do
    for package in ${packages[$group]}; do
      is_installed "$package" || echo "$package"
    done
  done | sort --unique
}

groups=("$@")
[[ ${#groups[@]} -gt 0 ]] || groups=(build)
for group in "${groups[@]}"; do
  [[ -n "${packages[$group]:-}" ]] || fail "there is no group '$group'; the groups are: ${!packages[*]}"
done
command -v dpkg-query >/dev/null || fail "this script needs Debian (or a system with apt-get and dpkg)"

mapfile -t missing < <(missing_packages "${groups[@]}")
if [[ ${#missing[@]} -eq 0 ]]; then
  echo "All packages of the groups '${groups[*]}' are installed."
  exit 0
fi
echo "Installing: ${missing[*]}"
as_root=()
if [[ $EUID -ne 0 ]]; then
  command -v sudo >/dev/null || fail "not root and no sudo here; as root run: apt-get install ${missing[*]}"
  as_root=(sudo)
fi
"${as_root[@]}" apt-get -qq update
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 install --yes --no-install-recommends "${missing[@]}"

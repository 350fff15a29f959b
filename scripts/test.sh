#!/usr/bin/env bash
# Installs what is missing, builds the release preset and runs all tests.
#
# usage: scripts/test.sh [arguments for ctest]     for instance: scripts/test.sh -R cad
source "$(dirname "$0")/common.sh"

./scripts/install-deps.sh build
say "Building (preset release)"
configure_and_build release
say "Testing"
ctest --preset release --parallel "$jobs" "$@"

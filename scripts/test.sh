#!/usr/bin/env bash
# Installs what is missing, builds everything and runs all tests, those of the readers with sanitizers, too.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/install_dependencies.sh
scripts/build.sh release
ctest --preset release -j "$(nproc)"
scripts/sanitized.sh

#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing, builds everything, runs all tests, those of the readers with sanitizers, too, and says at the end
# what ran and what was skipped and why.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/install_dependencies.sh
built=$SECONDS
scripts/build.sh release
tested=$SECONDS
rm -f build/release/tests.xml
# ctest's own code is not needed: the summary's is 1 when a test failed or none ran.
ctest --preset release --show-only=json-v1 >build/release/tests.json
ctest --preset release -j "$(nproc)" --output-junit tests.xml || true
sanitized=$SECONDS
readers=0
scripts/sanitized.sh || readers=$?
echo
echo "== $(. /etc/os-release && echo "$PRETTY_NAME"), $(c++ --version | head -n 1), $(nproc) cores"
echo "dependencies $built s, build $((tested - built)) s, tests $((sanitized - tested)) s, with sanitizers $((SECONDS - sanitized)) s"
tests=0
scripts/test_summary.py build/release/tests.xml build/release/tests.json || tests=$?
[ "$readers" -eq 0 ] || echo "FAILED: readers with sanitizers (code $readers; they report above)"
[ "$tests" -eq 0 ] || echo "FAILED: tests (code $tests)"
exit $((tests ? tests : readers))

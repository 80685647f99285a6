#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The long jobs, one after the other: scripts/nightly.sh [JOB...]; a whole night on few cores.
#   asan       everything under AddressSanitizer and UndefinedBehaviorSanitizer (preset asan)
#   tsan       the tracer and the trace reader's threads under ThreadSanitizer (preset tsan)
#   readers    every reader under libFuzzer, a million inputs or an hour each (preset fuzz, clang)
#   coverage   all tests in that build, then the lines that none of them ran
#   mutations  seeded mutations of all inputs, an hour
#   faults     each call fails once; a hundred kills a command; power loss at each moment
#   relations  two hundred random cases of each relation of scripts/metamorphic.py, others each night
#   model      two hundred changes of the model
#   pages      a quarter of the artifact's quick pages, another each night: figures within tolerance of those on record
#   compilers  g++ -O3, g++ -O0 and clang++ give the same bytes
# Each job's output is in build/nightly/JOB.log. Exit code 1: one of them found something.
set -uo pipefail
# GCC 12's sanitizers die where the kernel randomises more than 28 bits of addresses: there, everything runs without.
[ "$(cat /proc/sys/vm/mmap_rnd_bits)" -le 28 ] || ((0x$(cat /proc/self/personality) & 0x40000)) || exec setarch -R "$0" "$@"
cd "$(dirname "$0")/.."
jobs=${JOBS:-$(nproc)}
mkdir -p build/nightly

sanitized() {  # PRESET TARGETS...
  local preset=$1
  shift
  cmake --preset "$preset" && cmake --build --preset "$preset" -j "$jobs" ${@:+--target "$@"}
}
asan() {
  sanitized asan && ASAN_OPTIONS=detect_leaks=0:detect_stack_use_after_return=0 ctest --preset asan -j "$jobs"
}
# oneTBB and Embree are not instrumented: what they order is not seen (tests/tsan.supp).
tsan() {
  sanitized tsan base_tests traces_tests frontend_tests &&
    TSAN_OPTIONS="suppressions=$PWD/tests/tsan.supp" ctest --preset tsan -j "$jobs" -L '^(base|traces|frontend)$'
}
readers() { scripts/fuzz.sh --guided 1000000 3600; }
coverage() {
  sanitized fuzz || return 1
  local tests=0
  ASAN_OPTIONS=detect_leaks=0:detect_stack_use_after_return=0 LLVM_PROFILE_FILE="$PWD/build/fuzz/profile/%m_%p.profraw" \
    ctest --preset fuzz -j "$jobs" || tests=1
  scripts/coverage.py --lines && return $tests
}
mutations() { scripts/build.sh release reader_tests lab_tests view_tests rtl_tlm_tests && scripts/fuzz.sh 60; }
faults() { scripts/build.sh release grtx fault_injector && scripts/inject_faults.py --jobs "$jobs"; }
relations() {
  scripts/build.sh release grtx &&
    scripts/metamorphic.py --cases 200 --seed $((10#$(date +%j) * 1000)) --keep build/nightly/relations
}
model() { scripts/mutate_model.py --jobs "$jobs"; }
pages() {
  scripts/build.sh release grtx || return 1
  local item number=0 failed=0
  for item in $(PYTHONPATH=bench python3 -B -c 'from paper import items; print(*items.ITEMS)'); do
    if [ $((number++ % 4)) -eq $((10#$(date +%j) % 4)) ]; then
      scripts/reproduce.sh --quick --only "$item" --jobs "$jobs" -o build/nightly/pages || failed=1
    fi
  done
  return $failed
}
compilers() { scripts/compare_builds.sh; }

code=0
for job in "${@:-asan tsan readers coverage mutations faults relations model pages compilers}"; do
  for one in $job; do
    start=$(date +%s)
    if "$one" > "build/nightly/$one.log" 2>&1; then result=ok; else result=FAILED code=1; fi
    echo "$one: $result, $(($(date +%s) - start)) s (build/nightly/$one.log)"
  done
done
exit $code

#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The long jobs, one after the other: scripts/nightly.sh [JOB...]; a whole night on few cores.
#   asan       everything under AddressSanitizer and UndefinedBehaviorSanitizer (preset asan)
#   tsan       the tracer and the trace reader's threads under ThreadSanitizer (preset tsan)
#   readers    every reader under libFuzzer, a million inputs or an hour each (preset fuzz, clang)
#   coverage   all tests in that build, then the lines that none of them ran: build/fuzz/coverage/index.html
#   mutations  seeded mutations of all inputs, an hour
#   faults     each call fails once; a hundred kills a command; power loss at each moment
#   relations  two hundred random cases of each relation of scripts/metamorphic.py, others each night
#   model      two hundred changes of the model
#   pages      a quarter of the artifact's quick pages, another each night: figures within tolerance of those on record
#   shared     all libraries as shared ones, installed; a program of five lines finds them by CMake and by pkg-config
#   compilers  g++ -O3, g++ -O0 and clang++ give the same bytes
# Each job's output is in build/nightly/JOB.log. Exit code 1: one of them found something.
set -uo pipefail
# GCC 12's sanitizers die where the kernel randomises more than 28 bits of addresses: there, everything runs without.
[ "$(cat /proc/sys/vm/mmap_rnd_bits 2>/dev/null || echo 28)" -le 28 ] || ((0x$(cat /proc/self/personality) & 0x40000)) ||
  ! setarch -R true 2>/dev/null || exec setarch -R "$0" "$@"
cd "$(dirname "$0")/.." || exit 2
all="asan tsan readers coverage mutations faults relations model pages shared compilers"
for job in "$@"; do
  case " $all " in
    *" $job "*) ;;
    *) echo "nightly.sh: $job: must be one of $all" >&2; exit 2 ;;
  esac
done
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
  local tests=0 profile=$PWD/build/fuzz/profile version='' program objects=()
  rm -rf "$profile"  # of another night's programs: profiles add up
  ASAN_OPTIONS=detect_leaks=0:detect_stack_use_after_return=0 LLVM_PROFILE_FILE="$profile/%m_%p.profraw" \
    ctest --preset fuzz -j "$jobs" || tests=1
  command -v llvm-cov >/dev/null || version=-14
  find "$profile" -name '*.profraw' >"$profile/list"
  # A process that was killed leaves a profile that is cut off.
  llvm-profdata$version merge --sparse --failure-mode=all -f "$profile/list" -o "$profile/all" 2>/dev/null || return 1
  for program in build/fuzz/tests/*_tests build/fuzz/tests/fuzz_readers; do objects+=(-object "$program"); done
  objects+=(-instr-profile "$profile/all" -ignore-filename-regex='/(tests|build)/|^/usr/')
  llvm-cov$version show build/fuzz/grtx "${objects[@]}" -format=html -output-dir=build/fuzz/coverage &&
    llvm-cov$version report build/fuzz/grtx "${objects[@]}" && return $tests
}
mutations() { scripts/build.sh release reader_tests explore_tests report_tests rtl_tlm_tests && scripts/fuzz.sh 60; }
faults() { scripts/build.sh release grtx fault_injector && scripts/inject_faults.py --jobs "$jobs"; }
relations() {
  scripts/build.sh release grtx &&
    scripts/metamorphic.py --cases 200 --seed $((10#$(date +%j) * 1000)) --keep build/nightly/relations
}
model() { scripts/mutate_model.py --jobs "$jobs"; }
pages() {
  scripts/build.sh release grtx || return 1
  local item items number=0 failed=0
  items=$(PYTHONPATH=bench python3 -B -c 'from paper import items; print(*items.ITEMS)') || return 1
  for item in $items; do
    if [ $((number++ % 4)) -eq $((10#$(date +%j) % 4)) ]; then
      scripts/reproduce.sh --quick --only "$item" --jobs "$jobs" -o build/nightly/pages || failed=1
    fi
  done
  return $failed
}
shared() (  # its folder is its own
  local build=build/shared prefix=$PWD/build/shared/prefix five=$PWD/tests/package/outside/five_lines.cpp
  rm -rf "$prefix" build/shared/five
  cmake --preset release -B "$build" -DBUILD_SHARED_LIBS=ON -DGRTX_BUILD_TESTS=OFF -DGRTX_RTL=OFF &&
    cmake --build "$build" -j "$jobs" && cmake --install "$build" --prefix "$prefix" || return 1
  mkdir build/shared/five && cd build/shared/five || return 1
  printf '%s\n' 'cmake_minimum_required(VERSION 3.25)' 'project(five LANGUAGES CXX)' \
    'find_package(grtx_tlm 1.0 REQUIRED COMPONENTS sim)' "add_executable(five_lines $five)" \
    'target_link_libraries(five_lines PRIVATE grtx::sim)' >CMakeLists.txt
  cmake -G Ninja -B cmake -DCMAKE_PREFIX_PATH="$prefix" && cmake --build cmake && cmake/five_lines || return 1
  local flags
  flags=$(PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name grtx.pc)") pkg-config --cflags --libs grtx) || return 1
  # shellcheck disable=SC2086  # words
  c++ -std=c++20 "$five" $flags -Wl,-rpath,"$(dirname "$(find "$prefix" -name libgrtx_sim.so | head -n 1)")" -o by_pkg_config &&
    ./by_pkg_config && ldd by_pkg_config | grep -q libgrtx_sim
)
compilers() { scripts/compare_builds.sh; }

code=0
for job in ${@:-$all}; do
  start=$(date +%s)
  if "$job" > "build/nightly/$job.log" 2>&1; then result=ok; else result=FAILED code=1; fi
  echo "$job: $result, $(($(date +%s) - start)) s (build/nightly/$job.log)"
done
exit $code

#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The Debian packages: builds them for this system, or tries them in a bare one (as root).
# Usage: scripts/deb.sh [build [--no-charts] [FOLDER]]  makes FOLDER/grtx-tlm_*.deb, libgrtx-tlmX.Y_*.deb (the shared
#          libraries), grtx-tlm-dev_*.deb and python3-grtx-tlm_*.deb (build/packages)
#        scripts/deb.sh try PACKAGE CHROOT  installs PACKAGE there, makes a scene, runs a design, removes it; then the -dev
#          package beside it, with programs by find_package and pkg-config; then the Python package. Fails if a file stays.
#          CHROOT is / in a container.
#        debootstrap --variant=minbase bookworm CHROOT (or trixie) makes a bare chroot of Debian 12 (or 13).
set -euo pipefail

fail() { echo "deb.sh: $1" >&2; exit 2; }

build() {
  local charts=ON
  [ "${1:-}" != --no-charts ] || { charts=OFF; shift; }
  if [ "$charts" = ON ] && ! command -v npm >/dev/null; then
    fail "npm is missing, and reports would have no charts: install npm, or say --no-charts"
  fi
  for program in dpkg-shlibdeps:dpkg-dev file:file help2man:help2man; do
    command -v "${program%:*}" >/dev/null || fail "${program%:*} is missing, which finds a package's libraries or makes its manual: install ${program#*:}"
  done
  mkdir -p "${1:-$top/build/packages}"
  out=$(cd "${1:-$top/build/packages}" && pwd)
  cd "$top"
  # What a package holds does not depend on what else is installed: no RTL, with or without Verilator.
  cmake --preset release -B build/deb -DGRTX_REPORT_CHARTS="$charts" -DGRTX_RTL=OFF -DGRTX_BUILD_TESTS=OFF \
    -DBUILD_SHARED_LIBS=ON -DCMAKE_SKIP_INSTALL_RPATH=ON -DCMAKE_INSTALL_PREFIX=/usr
  cmake --build build/deb
  trap 'rm -rf "$out/_CPack_Packages"' EXIT  # what cpack installs to pack it
  cpack --config build/deb/CPackConfig.cmake -G DEB -B "$out"
  # cpack's scripts call ldconfig; Debian has a trigger for that.
  local library unpacked=$out/_CPack_Packages/library
  for library in "$out"/libgrtx-tlm*.deb; do
    rm -rf "$unpacked"
    dpkg-deb -R "$library" "$unpacked"
    rm -f "$unpacked"/DEBIAN/post{inst,rm}
    echo "activate-noawait ldconfig" >"$unpacked/DEBIAN/triggers"
    dpkg-deb --root-owner-group -b "$unpacked" "$library" >/dev/null
  done
  ls "$out"/*grtx-tlm*.deb
}

inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C DEBIAN_FRONTEND=noninteractive HOME=/root "$@"; }
# apt, or its last words.
apt() { inside apt-get "$@" >>"$work/log" 2>&1 || { tail -n 40 "$work/log" >&2; exit 1; }; }
# All names, without what apt and dpkg keep for themselves.
names() { (cd "$root" && find . -xdev \( -path ./proc -o -path ./tmp -o -path ./var/cache -o -path ./var/log -o -path ./var/lib/apt -o -path ./var/lib/dpkg \) -prune -o -print | sort); }
files() { inside dpkg -L "$@" | while read -r path; do [ -z "$path" ] || [ -d "$root$path" ] || echo ".$path"; done | sort -u; }
# gone FILES: none of them, and nothing else that has our name, is there any more.
gone() {
  local found=0
  names >"$work/after"
  comm -13 "$work/before" "$work/after" >"$work/stayed"
  while read -r path; do
    echo "deb.sh: $path: of the package, and there after its removal" >&2
    found=1
  done < <({ grep -xFf "$1" "$work/after" || true; grep -i grtx "$work/stayed" || true; } | sort -u)
  [ "$found" -eq 0 ] || exit 1
}

try() {
  local package=$1 dev library python
  dev=$(dirname "$1")/$(basename "$1" | sed 's/^grtx-tlm_/grtx-tlm-dev_/')
  library=$(dirname "$1")/$(basename "$1" | sed -E 's/^grtx-tlm_([0-9]+\.[0-9]+)/libgrtx-tlm\1_\1/')
  python=$(dirname "$1")/$(basename "$1" | sed -E 's/^grtx-tlm_(.*)_[^_]*\.deb$/python3-grtx-tlm_\1_all.deb/')
  for file in "$package" "$library" "$dev" "$python"; do
    [ -f "$file" ] || fail "$file: no such package"
  done
  [ -x "$2/usr/bin/apt-get" ] || fail "$2: must be a chroot of Debian (debootstrap makes one)"
  root=$(cd "$2" && pwd)
  [ "$(id -u)" -eq 0 ] || fail "try: must be run as root"
  work=$(mktemp -d)
  mounted=
  trap '[ -z "$mounted" ] || umount "$root/proc"; rm -rf "$work" "$root/tmp/grtx"' EXIT
  mkdir -p "$root/proc" "$root/tmp/grtx"
  mountpoint -q "$root/proc" || { mount -t proc proc "$root/proc"; mounted=yes; }
  cp "$package" "$root/tmp/grtx/grtx-tlm.deb"
  cp "$library" "$root/tmp/grtx/libgrtx-tlm.deb"
  cp "$dev" "$root/tmp/grtx/grtx-tlm-dev.deb"
  cp "$python" "$root/tmp/grtx/python3-grtx-tlm.deb"
  cp "$top/tests/package/outside/five_lines.cpp" "$root/tmp/grtx/"
  apt update -q
  names >"$work/before"

  apt install -y -q --no-install-recommends /tmp/grtx/grtx-tlm.deb /tmp/grtx/libgrtx-tlm.deb
  inside grtx --version
  inside grtx selftest
  inside grtx synth --preset object --count 2000 -o /tmp/grtx/object.ply
  inside grtx run --scene /tmp/grtx/object.ply --cameras /tmp/grtx/object.cameras.json --width 16 --height 16 \
    --machine ada-share --designs baseline,grtx --quiet -o /tmp/grtx/out
  inside test -s /tmp/grtx/out/report.html
  local soname
  soname=$(basename "$library" | cut -d_ -f1)
  files grtx-tlm "$soname" >"$work/files"
  apt purge -y -q --autoremove grtx-tlm "$soname"
  gone "$work/files"
  echo "$(wc -l <"$work/files") files came and went; of the libraries that came with it, $(wc -l <"$work/stayed") names stayed:"
  cat "$work/stayed"

  # All components are looked for: the package brings what they need, or configuring fails.
  cat >"$root/tmp/grtx/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(five_lines LANGUAGES CXX)
find_package(grtx_tlm 1.0 REQUIRED)
add_executable(five_lines five_lines.cpp)
target_link_libraries(five_lines PRIVATE grtx::sim)
END
  local tools=()
  for tool in g++ cmake make; do inside dpkg -s "$tool" >/dev/null 2>&1 || tools+=("$tool"); done
  apt install -y -q --no-install-recommends "${tools[@]}" /tmp/grtx/grtx-tlm.deb /tmp/grtx/libgrtx-tlm.deb /tmp/grtx/grtx-tlm-dev.deb
  # shellcheck disable=SC2016
  inside sh -ec 'cd /tmp/grtx && cmake -S . -B by_cmake && cmake --build by_cmake && by_cmake/five_lines
    c++ -std=c++20 five_lines.cpp $(pkg-config --cflags --libs grtx) -o by_pkg_config && ./by_pkg_config' >>"$work/log" 2>&1 ||
    { tail -n 40 "$work/log" >&2; exit 1; }
  files grtx-tlm "$soname" grtx-tlm-dev >"$work/files"
  apt purge -y -q --autoremove grtx-tlm "$soname" grtx-tlm-dev "${tools[@]}"
  gone "$work/files"
  echo "$(wc -l <"$work/files") files with the -dev package, and a program by find_package and by pkg-config"

  apt install -y -q --no-install-recommends /tmp/grtx/grtx-tlm.deb /tmp/grtx/libgrtx-tlm.deb /tmp/grtx/python3-grtx-tlm.deb
  # Root's Python writes what it compiles beside the sources.
  inside python3 -c 'import grtx_tlm; print(grtx_tlm.read_results("/tmp/grtx/out/results.json").speedup)' >>"$work/log" 2>&1 ||
    { tail -n 20 "$work/log" >&2; exit 1; }
  files grtx-tlm "$soname" python3-grtx-tlm >"$work/files"
  apt purge -y -q --autoremove grtx-tlm "$soname" python3-grtx-tlm
  gone "$work/files"
  echo "$(wc -l <"$work/files") files with the Python package, which reads a run's results"
}

top=$(cd "$(dirname "$0")/.." && pwd)
command=${1:-build}
[ $# -eq 0 ] || shift
case "$command:$#:${1:-}" in
  build:0:* | build:1:* | build:2:--no-charts) build "$@" ;;
  try:2:*) try "$@" ;;
  *) fail "$command: must be build [--no-charts] [FOLDER] or try PACKAGE CHROOT" ;;
esac

#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The Debian package: builds it for this system, or tries one in a bare chroot (as root).
# Usage: scripts/deb.sh [build [FOLDER]]    makes FOLDER/grtx-tlm_*.deb (build/packages)
#        scripts/deb.sh try PACKAGE CHROOT  installs it there, makes a scene, runs a design, removes it; fails if a file stays.
#        debootstrap --variant=minbase bookworm CHROOT (or trixie) makes a bare chroot of Debian 12 (or 13).
set -euo pipefail

fail() { echo "deb.sh: $1" >&2; exit 2; }

build() {
  mkdir -p "${1:-$top/build/packages}"
  out=$(cd "${1:-$top/build/packages}" && pwd)
  cd "$top"
  local charts=()
  command -v npm >/dev/null || charts=(-DGRTX_REPORT_CHARTS=OFF)
  cmake --preset release -B build/deb "${charts[@]}" -DGRTX_BUILD_TESTS=OFF -DCMAKE_INSTALL_PREFIX=/usr
  cmake --build build/deb
  trap 'rm -rf "$out/_CPack_Packages"' EXIT  # what cpack installs to pack it
  cpack --config build/deb/CPackConfig.cmake -G DEB -B "$out"
  ls "$out"/grtx-tlm_*.deb
}

inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C DEBIAN_FRONTEND=noninteractive HOME=/root "$@"; }
# All names, without what apt and dpkg keep for themselves.
names() { (cd "$root" && find . -xdev \( -path ./proc -o -path ./tmp -o -path ./var/cache -o -path ./var/log -o -path ./var/lib/apt -o -path ./var/lib/dpkg \) -prune -o -print | sort); }

try() {
  local package=$1 found=0
  [ -f "$package" ] || fail "$package: no such package"
  [ -x "$2/usr/bin/apt-get" ] || fail "$2: must be a chroot of Debian (debootstrap makes one)"
  root=$(cd "$2" && pwd)
  [ "$root" != / ] || fail "$2: must be a chroot, not this system"
  [ "$(id -u)" -eq 0 ] || fail "try: must be run as root"
  work=$(mktemp -d)
  mounted=
  trap '[ -z "$mounted" ] || umount "$root/proc"; rm -rf "$work" "$root/tmp/grtx"' EXIT
  mkdir -p "$root/proc" "$root/tmp/grtx"
  mountpoint -q "$root/proc" || { mount -t proc proc "$root/proc"; mounted=yes; }
  cp "$package" "$root/tmp/grtx/grtx-tlm.deb"
  inside apt-get update -q >"$work/log" 2>&1 || { tail -n 40 "$work/log" >&2; exit 1; }
  names >"$work/before"
  inside apt-get install -y -q --no-install-recommends /tmp/grtx/grtx-tlm.deb >>"$work/log" 2>&1 || { tail -n 40 "$work/log" >&2; exit 1; }
  inside grtx --version
  inside grtx synth --preset object --count 2000 -o /tmp/grtx/object.ply
  inside grtx run --scene /tmp/grtx/object.ply --cameras /tmp/grtx/object.cameras.json --width 16 --height 16 \
    --machine ada-share --designs baseline,grtx --quiet -o /tmp/grtx/out
  inside test -s /tmp/grtx/out/report.html
  inside dpkg -L grtx-tlm | while read -r path; do [ -d "$root$path" ] || echo ".$path"; done >"$work/files"
  inside apt-get purge -y -q --autoremove grtx-tlm >>"$work/log" 2>&1 || { tail -n 40 "$work/log" >&2; exit 1; }
  names >"$work/after"
  comm -13 "$work/before" "$work/after" >"$work/stayed"
  while read -r path; do
    echo "deb.sh: $path: of the package, and there after its removal" >&2
    found=1
  done < <({ grep -xFf "$work/files" "$work/after" || true; grep -i grtx "$work/stayed" || true; } | sort -u)
  [ "$found" -eq 0 ] || exit 1
  echo "$(wc -l <"$work/files") files came and went; of the libraries that came with it, $(wc -l <"$work/stayed") names stayed:"
  cat "$work/stayed"
}

top=$(cd "$(dirname "$0")/.." && pwd)
case "${1:-build}:$#" in
  build:[012]) build "${2:-}" ;;
  try:3) try "$2" "$3" ;;
  *) fail "$*: must be build [FOLDER] or try PACKAGE CHROOT" ;;
esac

#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the Debian packages that the build and the tests need; does nothing when all are present.
# As root, or with sudo. Debian 12 (bookworm) and 13 (trixie), which has no clang-format 14: the checks of layout skip there.
# Ubuntu 24.04 (noble), whose chromium is a snap and no package, and whose clang-tidy 14 does not understand the headers of
# GCC 13: tests of pages in a browser and clang-tidy skip there.
# Usage: scripts/install_dependencies.sh [--minimal]   (--minimal: only what the build, grtx and scripts/reproduce.sh need)
set -euo pipefail

packages=(
  g++ cmake ninja-build ccache pkg-config
  libsystemc-dev libembree-dev libglm-dev libtbb-dev libcli11-dev libtomlplusplus-dev nlohmann-json3-dev
  libfmt-dev libzstd-dev libxxhash-dev libpng-dev libopenexr-dev zlib1g-dev libsqlite3-dev libpagmo-dev
  libwebp-dev libzip-dev
  libgtest-dev libgmock-dev
  python3 xz-utils
)
case "$*" in
  --minimal) ;;
  "")
    packages+=(
      slurmctld slurmd slurm-client munge
      verilator yosys
      python3-numpy python3-pandas python3-matplotlib
      python3-pip python3-nbclient python3-nbformat python3-ipykernel
      git help2man reuse
      gtkwave xvfb xauth imagemagick fonts-dejavu-core
    )
    # shellcheck source=/dev/null
    system=$(. /etc/os-release && echo "${ID:-} ${VERSION_ID:-}")
    [ "$system" = "debian 13" ] || packages+=(clang-format-14)
    [ "$system" != "debian 12" ] || packages+=(clang-tidy-14)
    [ "${system%% *}" = ubuntu ] || packages+=(chromium)  # what has this name there only asks for the snap
    # The build fetches the reports' charts with npm, and their tests run in node: any npm will do, also one from elsewhere.
    command -v npm >/dev/null || packages+=(nodejs npm)
    ;;
  *) echo "install_dependencies.sh: $*: must be --minimal or nothing" >&2; exit 2 ;;
esac

for program in dpkg-query apt-get; do
  command -v $program >/dev/null || { echo "install_dependencies.sh: no $program: must be Debian 12 or 13, or Ubuntu 24.04; needed: ${packages[*]}" >&2; exit 2; }
done
missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "install_dependencies.sh: run as root or install sudo; needed: ${missing[*]}" >&2; exit 2; }
  as_root=(sudo)
fi
echo "Installing: ${missing[*]}"

log=$(mktemp)
trap 'rm -f "$log"' EXIT
# A line each fifth of the packages. From what apt prints: its own status descriptor makes scripts of packages fail where there is no /dev/pts.
progress() {
  awk '/ newly installed,/ { total = $3 }
       /^Fetched / { print "  downloaded"; fflush() }
       /^Setting up / { step = total ? int(++done * 5 / total) : 0; if (step > last) { last = step; print "  installed " step * 20 " %"; fflush() } }'
}
if ! { "${as_root[@]}" apt-get update -q >"$log" 2>&1 &&
       "${as_root[@]}" env LC_ALL=C DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends -o DPkg::Use-Pty=0 \
         "${missing[@]}" 2>&1 | tee -a "$log" | progress; }; then
  tail -n 40 "$log" >&2
  exit 1
fi

#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Takes a picture of GTKWave showing a save file that `grtx sim --vcd` wrote, on an X server without a screen.
#   scripts/gtkwave_screenshot.sh SAVE.gtkw OUT.png [WIDTHxHEIGHT]
# Needs gtkwave, xvfb, xauth and imagemagick (import). Exit code 3: one of them is missing.
set -eu
save=$(realpath "${1:?save file}") out=$(realpath "${2:?picture}") size=${3:-1500x950}
for tool in gtkwave xvfb-run xauth import; do
  command -v "$tool" >/dev/null || { echo "gtkwave_screenshot: $tool is not installed" >&2; exit 3; }
done
# A home of its own: no settings of the user, and no dialogs.
HOME=$(mktemp -d)
export HOME save out XDG_CONFIG_HOME="$HOME" NO_AT_BRIDGE=1
trap 'rm -rf "$HOME"' EXIT
printf '%s\n' 'splash_disable 1' 'hide_sst 1' 'fontname_signals Sans 10' 'fontname_waves Sans 9' >"$HOME/.gtkwaverc"
# shellcheck disable=SC2016
xvfb-run -a -s "-screen 0 ${size}x24 -nolisten tcp" sh -euc '
  gtkwave --rcfile="$HOME/.gtkwaverc" --save="$save" >"$HOME/log" 2>&1 &
  viewer=$! before=
  for _ in $(seq 60); do  # ready when two pictures in a row are equal and not one colour
    sleep 1
    kill -0 $viewer 2>/dev/null || { cat "$HOME/log" >&2; exit 1; }
    import -window root "$HOME/screen.png"
    now=$(identify -format "%k %#" "$HOME/screen.png")
    [ "$now" = "$before" ] && [ "${now%% *}" -gt 16 ] && break
    before=$now
  done
  kill $viewer
  convert "$HOME/screen.png" -colors 64 -define png:compression-level=9 "PNG8:$out"'

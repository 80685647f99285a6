#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Takes a picture of GTKWave showing a save file that `grtx sim --vcd` wrote, on an X server without a screen.
#   scripts/gtkwave_screenshot.sh SAVE.gtkw OUT.png [WIDTHxHEIGHT]
# Needs gtkwave, xvfb, x11-apps (xwd) and imagemagick (convert). Exit code 3: one of them is missing.
set -eu

save=${1:?save file}
out=${2:?picture}
size=${3:-1500x950}
for tool in gtkwave Xvfb xwd convert; do
  command -v "$tool" >/dev/null || { echo "gtkwave_screenshot: $tool is not installed" >&2; exit 3; }
done

folder=$(mktemp -d)
server=
viewer=
finish() {
  [ -z "$viewer" ] || kill "$viewer" 2>/dev/null || true
  [ -z "$server" ] || kill "$server" 2>/dev/null || true
  rm -rf "$folder"
}
trap finish EXIT
trap 'exit 1' INT TERM

# The server chooses a free display and writes its number.
Xvfb -displayfd 3 -screen 0 "${size}x24" -nolisten tcp 3>"$folder/display" >/dev/null 2>&1 &
server=$!
for _ in $(seq 100); do
  [ -s "$folder/display" ] && break
  sleep 0.1
done
DISPLAY=:$(cat "$folder/display")
export DISPLAY
# A home of its own: no settings of the user, and no dialogs.
export HOME="$folder" XDG_CONFIG_HOME="$folder" NO_AT_BRIDGE=1
cat >"$folder/.gtkwaverc" <<'SETTINGS'
splash_disable 1
hide_sst 1
fontname_signals Sans 10
fontname_waves Sans 9
SETTINGS
gtkwave --rcfile="$folder/.gtkwaverc" --save="$save" >"$folder/log" 2>&1 &
viewer=$!

# It is ready when two pictures in a row are equal and not one colour.
before=
for _ in $(seq 60); do
  sleep 1
  kill -0 "$viewer" 2>/dev/null || { cat "$folder/log" >&2; exit 1; }
  xwd -root -silent -out "$folder/screen.xwd"
  now=$(cksum <"$folder/screen.xwd")
  colours=$(convert "xwd:$folder/screen.xwd" -format '%k' info:)
  [ "$now" = "$before" ] && [ "$colours" -gt 16 ] && break
  before=$now
done
convert "xwd:$folder/screen.xwd" -colors 64 -define png:compression-level=9 "PNG8:$out"

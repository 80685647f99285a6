#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Brings the public scenes of configs/scenes/scenes.txt as .ply with their cameras into a folder: each from its
# repository at a pinned commit, one level of detail where it has several, and only if the result has the SHA-256 on record.
# Usage: scripts/scenes.sh FOLDER [--clones FOLDER] [--only NAME] [--program GRTX] [--list FILE]
#   --clones   clones lie here as OWNER/NAME or NAME, bare or not; what is missing comes from the network
#   --only     this scene alone
#   --program  this grtx (default build/release/grtx)
#   --list     another list of scenes
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
fail() { echo "scenes.sh: $2" >&2; exit "$1"; }
into= clones= only= grtx=$here/build/release/grtx list=$here/configs/scenes/scenes.txt
while [ $# -gt 0 ]; do
  case "$1:${2:+value}" in
    --clones:value) clones=$2; shift ;;
    --only:value) only=$2; shift ;;
    --program:value) grtx=$2; shift ;;
    --list:value) list=$2; shift ;;
    -*) fail 2 "$1: must be FOLDER, --clones FOLDER, --only NAME, --program GRTX or --list FILE" ;;
    *) [ -z "$into" ] || fail 2 "$1: one folder only"; into=$1 ;;
  esac
  shift
done
[ -n "$into" ] || fail 2 "FOLDER: is missing"
command -v git >/dev/null || fail 2 "git is missing (apt-get install git)"
[ -x "$grtx" ] || fail 2 "$grtx: no such program; build it (scripts/build.sh release grtx) or name one with --program"
[ -r "$list" ] || fail 2 "$list: cannot be read"
mkdir -p "$into"
work=$(mktemp -d "$into/.scenes.XXXXXX")
trap 'rm -rf "$work"' EXIT

# The files of a scene, or of one level and what describes it, from a clone (first argument) at a commit, into $work/source.
# From a checkout of ours they are copied: an archive would first fetch all that a partial clone of a repository lacks.
extract() {  # CLONE COMMIT FOLDER LEVEL
  local names tree=$2:${3#.}
  mkdir -p "$work/source"
  names=$(git -C "$1" ls-tree -r --name-only "$tree" | grep -E "$([ "$4" = - ] && echo . || echo "^(lod-meta\.json|$4_[0-9]+/[^/]+)\$")" || true)
  [ -n "$names" ] || return 1
  if [ "$1" = "$work/clone" ]; then
    printf '%s\n' "$names" | tar -c -C "$1/$3" -T - | tar -x -C "$work/source"
  else
    printf '%s\n' "$names" | tr '\n' '\0' | xargs -0 git -C "$1" archive "$tree" -- | tar -x -C "$work/source"
  fi
}

found=0
while read -r name repository commit folder level sha <&3 || [ -n "$name" ]; do
  case "$name" in '' | '#'*) continue ;; esac
  [ -z "$only" ] || [ "$only" = "$name" ] || continue
  found=1
  if [ -f "$into/$name.ply" ] && [ "$(sha256sum <"$into/$name.ply")" = "$sha  -" ]; then
    [ -f "$into/$name.cameras.json" ] || cp "${list%/*}/$name.cameras.json" "$into/"
    echo "$name: is there"
    continue
  fi
  clone=
  for place in "$clones/$repository" "$clones/${repository##*/}"; do
    [ -n "$clones" ] && git -C "$place" cat-file -e "$commit^{commit}" 2>/dev/null && clone=$place && break
  done
  if [ -z "$clone" ]; then
    clone=$work/clone
    echo "$name: cloning https://github.com/$repository"
    git clone -q --no-checkout --filter=blob:none "https://github.com/$repository" "$clone" ||
      fail 1 "$name: https://github.com/$repository could not be cloned; a clone of yours is taken with --clones"
    # Checking out brings these files alone, at once.
    at=/${folder#.}
    at=${at%/}  # nothing for the repository's top: patterns that begin with // match nothing
    wanted=("$at/lod-meta.json" "$at/${level}_*/")
    [ "$level" != - ] || wanted=("$at/*")
    git -C "$clone" sparse-checkout set --no-cone "${wanted[@]}"
    git -C "$clone" checkout -q "$commit" || fail 1 "$name: $repository has no commit $commit"
  fi
  extract "$clone" "$commit" "$folder" "$level" || fail 1 "$name: $clone lacks files of level $level in $folder at $commit"
  meta=(lod-meta.json --lod "$level")
  [ "$level" != - ] || meta=(meta.json)
  "$grtx" convert "$work/source/${meta[0]}" "$work/$name.ply" "${meta[@]:1}" --quiet
  is=$(sha256sum <"$work/$name.ply")
  [ "$is" = "$sha  -" ] || fail 1 "$name: SHA-256 is ${is%% *}, on record is $sha"
  cp "${list%/*}/$name.cameras.json" "$into/"
  mv "$work/$name.ply" "$into/"
  rm -rf "$work/source" "$work/clone"
  echo "$name: $into/$name.ply"
done 3<"$list"
[ "$found" = 1 ] || fail 2 "$only: no such scene in $list"

#!/usr/bin/env bash
# docs/units as systemd reads them: every line is one it knows.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
command -v systemd-analyze >/dev/null || { echo "systemd-analyze is not installed"; exit 77; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for unit in "$root"/docs/units/*; do  # the program need not be installed here
  sed 's#/usr/local/bin/subpixel#/bin/true#' "$unit" >"$folder/$(basename "$unit")"
done
for unit in "$folder"/*; do
  said=$(SYSTEMD_UNIT_PATH="$folder:" systemd-analyze verify --man=no "$unit" 2>&1) || { echo "$said"; exit 1; }
  # Of other units of the machine it may have something to say, too.
  case "$said" in *"$folder"*) echo "$said"; exit 1 ;; esac
done
echo "Lines=unknown" >>"$folder/subpixel.service"
said=$(SYSTEMD_UNIT_PATH="$folder:" systemd-analyze verify --man=no "$folder/subpixel.service" 2>&1) || true
case "$said" in *Lines*) ;; *) echo "an unknown line is not told: $said"; exit 1 ;; esac

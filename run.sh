#!/usr/bin/env bash
# From a clone to a page: installs packages, builds, replays the demo capture, prints its table and serves the viewer.
#   ./run.sh              then open the address it prints; Ctrl-C ends it
#   ./run.sh --no-serve   stops after the table
# SUBPIXEL_LISTEN=HOST:PORT chooses the address, SUBPIXEL_MESA the Mesa (see scripts/install.sh).
set -euo pipefail
cd "$(dirname "$0")"

serve=yes
for argument in "$@"; do
  case "$argument" in
    --no-serve) serve=no ;;
    *) echo "usage: ./run.sh [--no-serve]" >&2; exit 2 ;;
  esac
done
listen=${SUBPIXEL_LISTEN:-127.0.0.1:8080}
subpixel=build/release/subpixel
scene=capture_format/import/scenes/park.json
capture=demo/park.spcap
results=demo/results/results.json
# A size and a reference that two cores finish in minutes; the table's head states both.
size=1280x720
options=(--techniques "noaa,streaming,msaa" --samples 8 --reference-samples 64)

step() { printf '\n== %s\n' "$*"; }

step "1/4 packages"
scripts/install.sh

step "2/4 build"
[ -e build/release/build.ninja ] || cmake --preset release
cmake --build --preset release --target subpixel

step "3/4 demo capture: park, 3 frames of $size"
mkdir -p demo
if [ ! -e "$capture" ] || [ "$scene" -nt "$capture" ]; then
  # Under its name only when it is whole, so that a broken off run leaves nothing that looks finished.
  "$subpixel" import "$scene" demo/part.spcap --frames 3 --size "$size"
  mv demo/part.spcap "$capture"
else
  echo "$capture is there"
fi

step "4/4 replay"
if [ -e "$results" ] && [ -e demo/results/table.txt ] && [ "$results" -nt "$capture" ] && [ "$results" -nt "$subpixel" ]
then
  cat demo/results/table.txt
  printf '\nmeasured earlier; delete demo/results to measure again\n'
else
  rm -f "$results"
  "$subpixel" replay "$capture" "${options[@]}" --out demo/results --json "$results" --cache demo/data/cache |
    tee demo/table.part
  mv demo/table.part demo/results/table.txt
fi
[ "$serve" = yes ] || exit 0

step "viewer"
"$subpixel" serve --data demo/data --listen "$listen" &
server=$!
trap 'kill -TERM "$server" 2>/dev/null || true; wait "$server" 2>/dev/null || true; exit 0' INT TERM
# The port that answers must be this server's: it has to be alive as well.
for _ in $(seq 100); do
  kill -0 "$server" 2>/dev/null || { wait "$server"; exit $?; }
  (exec 3<>"/dev/tcp/${listen%:*}/${listen##*:}") 2>/dev/null && break
  sleep 0.1
done
if [ ! -e demo/data/demo-submitted ]; then
  # The run of the page repeats the one above; its references are in the shared cache already.
  if "$subpixel" submit "$capture" --server "http://$listen" "${options[@]}"; then
    touch demo/data/demo-submitted
  fi
fi
printf '\nThe viewer is at http://%s/  (Ctrl-C ends it)\n' "$listen"
wait "$server"

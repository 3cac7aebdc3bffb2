#!/usr/bin/env bash
# From a clone to a page: installs packages, builds, serves the viewer, replays the demo capture through it and prints
# the table of its results.
#   ./run.sh              the page can be looked at while the demo is measured; Ctrl-C ends it
#   ./run.sh --no-serve   replays without the service and stops after the table
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
scene=scenes/described/park.json
capture=demo/park.spcap
# A size and a reference that two cores finish in minutes; the table's head states both.
size=1280x720
options=(--techniques "noaa,streaming,msaa" --samples 8 --reference-samples 64)

step() { printf '\n== %s\n' "$*"; }
# Whether the file $1 was made with this build, of this capture.
is_recent() { [ -e "$1" ] && [ "$1" -nt "$capture" ] && [ "$1" -nt "$subpixel" ]; }

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

if [ "$serve" = no ]; then
  step "4/4 replay"
  table=demo/results/table.txt
  if is_recent "$table"; then
    cat "$table"
    printf '\nmeasured earlier; delete demo/results to measure again\n'
  else
    rm -f "$table"
    "$subpixel" replay "$capture" "${options[@]}" --out demo/results --cache demo/data/cache >demo/table.part
    mv demo/table.part "$table"
    cat "$table"
  fi
  exit 0
fi

step "4/4 viewer and replay"
mkdir -p demo/data
# Who names another address wants the demo there: whoever reaches it may use it.
"$subpixel" serve --data demo/data --listen "$listen" ${SUBPIXEL_LISTEN:+--no-token} >demo/address &
server=$!
end_service() {
  kill -TERM "$server" 2>/dev/null || true
  wait "$server" 2>/dev/null || true
}
trap end_service EXIT
trap 'printf "\nended; what is measured is kept\n"; exit 130' INT TERM
# Standard output of the service is its address and nothing else.
for _ in $(seq 300); do
  [ -s demo/address ] && break
  kill -0 "$server" 2>/dev/null || { code=0; wait "$server" || code=$?; exit "$code"; }
  sleep 0.1
done
address=$(sed -n 's/^listening on //p' demo/address)
[ -n "$address" ] || { echo "subpixel: the service does not start: see its messages above" >&2; exit 1; }
printf '\nThe viewer is at %s/  (results appear there as they are measured)\n\n' "$address"

# A run of another build or capture is not taken for this one's; one that was broken off goes on where it was.
submitted=demo/data/demo-submitted
if ! is_recent "$submitted"; then
  "$subpixel" submit "$capture" --server "$address" "${options[@]}" >/dev/null
  touch "$submitted"
fi
"$subpixel" submit "$capture" --server "$address" "${options[@]}" --once --wait

printf '\nThe viewer is at %s/  (Ctrl-C ends it)\n' "$address"
trap 'exit 0' INT TERM
wait "$server"

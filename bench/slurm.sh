#!/usr/bin/env bash
# What a shard costs, and one node and two against no Slurm: docs/scaling.md. Lavapipe on one thread, so that two nodes of
# one 2-core machine are two cores.
#   bench/slurm.sh build/release/subpixel [FRAMES]     8 frames; 2 only show that it runs
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
subpixel=$(realpath "$1") frames=${2:-8}
all=$((4 * frames))  # results
. "$here/../tests/slurm/cluster.sh"
reason=$(missing_slurm)
[ -z "$reason" ] || { echo "$reason"; exit 1; }
export LP_NUM_THREADS=1
folder=$(mktemp -d)
trap 'stop_cluster; rm -rf "$folder"' EXIT
start_cluster "$folder/cluster"
cat >"$folder/night.json" <<JSON
{"name": "shards", "techniques": "noaa,msaa,streaming,dcaa", "size": [640, 360], "frames": [0, $((frames - 1))], "repeat": 3,
 "reference_samples": 16, "captures": [{"scene": "city", "density": 0.3}], "gates": {"time": false}}
JSON
# night WHAT DATA OPTION...: seconds of a night of which only references and shaders are there
night() {
  local what=$1 data=$folder/$2 began; shift 2
  rm -f "$data"/subpixel.sqlite*
  began=$(date +%s.%N)
  "$subpixel" nightly --config "$folder/night.json" --data "$data" "$@" >"$folder/out" 2>&1 || { cat "$folder/out"; exit 1; }
  awk -v what="$what" -v began="$began" -v ended="$(date +%s.%N)" 'BEGIN { printf "| %s | %.1f |\n", what, ended - began }'
}
printf '| a night of %s results | s |\n| --- | --- |\n' "$all"
night "no Slurm, first" local
night "no Slurm" local
for results in "$all" $((all / 2)) $((all / 4)) $((all / 8)); do
  night "first of $results results a shard" "$results" --engine slurm --shard-results "$results" >/dev/null
  night "one node, $((all / results)) shards" "$results" --engine slurm --shard-results "$results" --sbatch=--nodelist=n1
  night "two nodes, $((all / results)) shards" "$results" --engine slurm --shard-results "$results"
done

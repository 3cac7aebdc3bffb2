#!/usr/bin/env bash
# `subpixel nightly` and `replay` by a real Slurm of two nodes, which this starts in a temporary folder and ends again.
#   slurm_test.sh SUBPIXEL FAKE_WORKER [CASE...]     exit code 1 when a case failed, 77 without Slurm
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
subpixel=$(realpath "$1") fake=$(realpath "$2")
shift 2
. "$here/cluster.sh"
. "$here/accounting.sh"
reason=$(missing_slurm)
[ -z "$reason" ] || { echo "skipped: $reason"; exit 77; }

folder=$(mktemp -d "${TMPDIR:-/tmp}/subpixel-slurm-XXXXXX")
failures=0
cleanup() {
  stop_cluster
  if [ "$failures" = 0 ]; then rm -rf "$folder"; else echo "kept: $folder"; fi
}
trap cleanup EXIT
case_failed() { echo "FAILED: $*"; failures=$((failures + 1)); }
# expect CODE WORDS FILE COMMAND...: how it ends, and that FILE, which takes all it prints, has the words
expect() {
  local code=$1 words=$2 out=$3 got=0; shift 3
  "$@" >"$out" 2>&1 || got=$?
  [ "$got" = "$code" ] || { case_failed "exit code $got, not $code: $*"; tail -n 5 "$out"; }
  grep -q -- "$words" "$out" || { case_failed "no word of '$words': $*"; tail -n 5 "$out"; }
}
# A made-up capture of FRAMES frames whose results take MS each, and a configuration of a night of it.
made_up() {
  printf 'FAKE {"frames": %s, "result_ms": %s, "title": "%s"}\n' "$2" "$3" "$1" >"$folder/$1.fake"
  cat >"$folder/$1.json" <<JSON
{"name": "$1", "techniques": "noaa,msaa:samples=4,msaa", "reference_samples": 16, "repeat": 1,
 "captures": [{"path": "$1.fake"}], "gates": {"time": false}}
JSON
}
nightly() { "$subpixel" nightly --config "$1" --data "$2" --worker-program "$fake" "${@:3}"; }
by_slurm() { nightly "$@" --engine slurm; }
queue_is_empty() { [ -z "$(squeue -h -p main -o %i)" ]; }

# Images, maps, counters and errors of a night that is divided are those of one that is not: the product's own worker,
# with a technique that looks at frames before, two references a frame and flicker from frame to frame.
case_equal() {
  cat >"$folder/equal.json" <<JSON
{"name": "equal", "techniques": "noaa,taa,msaa:samples=4,msaa:samples=4:shading=blinn_phong,dcaa,streaming",
 "size": [64, 48], "frames": [0, 2], "repeat": 1, "reference_samples": 16,
 "captures": [{"scene": "quads"}, {"scene": "grass", "density": 0.02, "frames": [0, 1]}], "gates": {"time": false}}
JSON
  expect 0 "night 1 of equal passed" "$folder/equal.local" \
    "$subpixel" nightly --config "$folder/equal.json" --data "$folder/local"
  expect 0 "night 1 of equal passed" "$folder/equal.slurm" \
    "$subpixel" nightly --config "$folder/equal.json" --data "$folder/shared" --engine slurm --shard-results 4
  grep -q "5 frames' references first" "$folder/equal.slurm" || case_failed "references are no jobs of their own"
  "$here/equal_nights.py" "$folder/local" "$folder/shared" || case_failed "the nights differ"
  # The next one knows times and references, and is compared with what was approved.
  "$subpixel" baseline set equal --data "$folder/shared" >"$folder/equal.set"
  expect 0 "2 captures in 2 shards, 0 frames' references first" "$folder/equal.second" \
    "$subpixel" nightly --config "$folder/equal.json" --data "$folder/shared" --engine slurm
  "$here/equal_nights.py" "$folder/local" "$folder/shared" || case_failed "the second night differs"
  # A replay's folder has the same files.
  "$subpixel" generate quads "$folder/quads.spcap" --frames 2 >"$folder/equal.generate"
  local to
  for to in here there; do
    "$subpixel" replay "$folder/quads.spcap" --techniques noaa,msaa:samples=4:shading=blinn_phong,taa --size 64x48 --repeat 1 \
      --reference-samples 16 --out "$folder/$to" --cache "$folder/cache-$to" \
      $([ $to = here ] || echo --engine slurm --shard-results 2) >"$folder/equal.$to" 2>&1 || case_failed "replay $to"
  done
  local pictures; pictures=$(cd "$folder/here" && ls ./*.png ./*.exr)
  [ "$pictures" = "$(cd "$folder/there" && ls ./*.png ./*.exr)" ] || case_failed "the replays have other files"
  for to in $pictures; do cmp "$folder/here/$to" "$folder/there/$to" || case_failed "$to differs"; done
}

# A node that dies with its daemon, its steps and their workers loses no result: they are measured again on the other.
case_killed() {
  local name=${1:-killed}
  made_up "$name" 4 1500
  nightly "$folder/$name.json" "$folder/$name-local" >"$folder/$name.local" 2>&1 || case_failed "the local night"
  by_slurm "$folder/$name.json" "$folder/$name-data" --shard-results 3 >"$folder/$name.out" 2>&1 &
  local night=$!
  wait_for "a result of a node" results_of "$folder/$name-data" n1
  kill_node n1
  wait "$night" || case_failed "the night after a node was killed"
  grep -q "was lost on n1 (NODE_FAIL" "$folder/$name.out" || { case_failed "nothing was lost"; cat "$folder/$name.out"; }
  "$here/equal_nights.py" "$folder/$name-local" "$folder/$name-data" || case_failed "a killed node changed the night"
  start_node n1
  wait_for "the node to be back" nodes_idle 2
}
# Whether a task runs on the node and some shard has a result.
results_of() {
  [ -n "$(squeue -h -r -t RUNNING -w "$2" -o %i)" ] && ls "$1"/slurm/subpixel-*/results/s*/*.json >/dev/null 2>&1
}

# A queue that others have filled: words and 4 when it stays so, a night when it does not.
case_full() {
  made_up full 2 0
  local size
  # Whatever is free of MaxJobCount, in which jobs that have ended count for a while.
  for size in 128 64 32 16 8 4 2 1; do
    timeout 2 sbatch --hold --array=0-$((size - 1)) -J others -o /dev/null "$folder/sleep.sh" >>"$folder/full.id" 2>&1 || true
  done
  expect 4 "the queue has been full for 1 s, nothing could be submitted (.*temporarily unable to accept job" \
    "$folder/full.out" by_slurm "$folder/full.json" "$folder/full-data" --slurm-patience 1
  by_slurm "$folder/full.json" "$folder/full-data" >"$folder/full.later" 2>&1 &
  local night=$!
  wait_for "the night to wait" grep -q "the queue is full, waiting" "$folder/full.later"
  scancel -n others
  wait "$night" || case_failed "the night that waited"
}

# An array that someone cancels is not started again: its capture fails in words, and 1; of a replay 4.
case_cancelled() {
  local name=${1:-cancelled}
  made_up "$name" 2 60000
  by_slurm "$folder/$name.json" "$folder/$name-data" >"$folder/$name.out" 2>&1 &
  local night=$! code=0
  wait_for "a task to run" running_tasks
  sleep 1
  scancel $(squeue -h -p main -o %F | sort -u)
  wait "$night" || code=$?
  [ "$code" = 1 ] || case_failed "exit code $code of a night that was cancelled"
  grep -q "the Slurm job [0-9]*_0 was cancelled" "$folder/$name.out" || { case_failed "no word of it"; cat "$folder/$name.out"; }
}
running_tasks() { [ -n "$(squeue -h -r -p main -t RUNNING -o %i)" ]; }

# SIGTERM takes its jobs with it, and so does the next night with those of one that was killed.
case_ended() {
  made_up ended 2 60000
  # No function: a signal has to reach the program, not a shell of its own.
  local command=("$subpixel" nightly --config "$folder/ended.json" --data "$folder/ended-data" --worker-program "$fake" --engine slurm)
  "${command[@]}" >"$folder/ended.out" 2>&1 &
  local night=$! code=0
  wait_for "a task to run" running_tasks
  kill -TERM "$night"
  wait "$night" || code=$?
  [ "$code" = 4 ] || case_failed "exit code $code after SIGTERM"
  wait_for "its jobs to be gone" queue_is_empty
  "${command[@]}" >"$folder/ended.killed" 2>&1 &
  night=$!
  wait_for "a task to run" running_tasks
  kill -KILL "$night"
  wait "$night" 2>/dev/null || true
  sed -i 's/60000/0/' "$folder/ended.fake"
  expect 0 "passed" "$folder/ended.next" by_slurm "$folder/ended.json" "$folder/ended-data"
  wait_for "the killed one's jobs to be gone" queue_is_empty
}

# Slurm's shortest limit is a minute, so this one runs beside the others, on a node of its own.
case_timed_out() {
  made_up timed_out 2 300000
  expect 1 "lost 1 times (on n3): it ran past its time limit of 1 min" "$folder/timed_out.out" \
    by_slurm "$folder/timed_out.json" "$folder/timed_out-data" --shard-minutes 1 --shard-retries 0 --shard-results 6 --partition slow
}

case_drained() {
  made_up drained 1 0
  scontrol update nodename=n1,n2 state=drain reason="broken fan"
  expect 4 "no node could run anything for 1 s (.*): n1 drain[a-z]* (broken fan), n2 drain[a-z]* (broken fan): the default partition" \
    "$folder/drained.out" by_slurm "$folder/drained.json" "$folder/drained-data" --slurm-patience 1
  scontrol update nodename=n1,n2 state=resume
  scontrol update partition=main state=drain
  expect 4 "Required partition not available" "$folder/drained.partition" \
    by_slurm "$folder/drained.json" "$folder/drained-data"
  scontrol update partition=main state=up
  expect 2 "no such partition\|nvalid partition" "$folder/drained.none" \
    by_slurm "$folder/drained.json" "$folder/drained-data" --partition none
  expect 2 "unrecognized option" "$folder/drained.option" \
    by_slurm "$folder/drained.json" "$folder/drained-data" --sbatch=--no-such-option
}

case_missing() {
  made_up missing 1 0
  expect 4 "there is no program sbatch; is Slurm installed" "$folder/missing.out" \
    env PATH=/nowhere "$subpixel" nightly --config "$folder/missing.json" --data "$folder/missing-data" \
    --worker-program "$fake" --engine slurm
  expect 4 "nable to contact slurm controller" "$folder/missing.silent" \
    env SLURM_CONF="$folder/nobody.conf" "$subpixel" nightly --config "$folder/missing.json" --data "$folder/missing-data" \
    --worker-program "$fake" --engine slurm
}

# What ends how is asked of sacct where there is accounting: a dead node and a cancelled array of another cluster, with a
# scontrol that knows no jobs.
case_accounting() {
  local reason; reason=$(missing_accounting)
  [ -z "$reason" ] || { echo "accounting: left out: $reason"; return 0; }
  (
    trap stop_cluster EXIT
    start_cluster_with_accounting "$folder/accounting"
    mkdir "$folder/without"
    cat >"$folder/without/scontrol" <<SH
#!/bin/sh
case "\$*" in *"show job"*) exit 1 ;; esac
exec $(command -v scontrol) "\$@"
SH
    chmod 755 "$folder/without/scontrol"
    PATH=$folder/without:$PATH
    case_killed accounted
    wait_for "the dead node in sacct" sacct_says NODE_FAIL
    case_cancelled accounted_cancelled
    wait_for "the cancelled tasks in sacct" sacct_says "CANCELLED by 0"
    exit "$failures"
  ) || failures=$((failures + 1))
}
sacct_says() { [ "$(sacct -n -X -P -o State | grep -c "^$1")" != 0 ]; }

printf '#!/bin/sh\nsleep 600\n' >"$folder/sleep.sh"
start_cluster "$folder/cluster" MaxJobCount=250
sed 's/^SlurmctldPort=.*/SlurmctldPort=1/; s/^MessageTimeout=.*/MessageTimeout=1/' "$SLURM_CONF" >"$folder/nobody.conf"
cases=("$@")
[ ${#cases[@]} -gt 0 ] || cases=(timed_out equal missing cancelled ended drained full killed)  # accounting by name: minutes
beside=
for name in "${cases[@]}"; do
  if [ "$name" = timed_out ]; then
    { case_timed_out; exit "$failures"; } &
    beside=$!
    continue
  fi
  SECONDS=0
  "case_$name"
  echo "$name: $SECONDS s"
done
if [ -n "$beside" ]; then wait "$beside" || failures=$((failures + 1)); fi
[ "$failures" = 0 ]

#!/usr/bin/env bash
# Whether each folder includes, of ours, only what stands beside it here, which is what its library may link
# (docs/architecture.md). Headers that only shaders and host share are everybody's.
set -euo pipefail
cd "$(dirname "$0")/../.."

layers='
base:
capture_format: base
capture_format/reading: base capture_format
capture_format/tools: base capture_format
recorder: base capture_format
scenes/builder: base capture_format
scenes/generate: base capture_format scenes/builder
scenes/import: base capture_format scenes/builder scenes/generate
shaders:
replay/results: base capture_format
replay/measure: base
replay/gpu: base shaders
replay: base capture_format capture_format/reading shaders replay/results replay/measure replay/gpu
process: base
web: base
server/store: base replay/results
server/engine: base process replay/results server/store
server/nightly: base capture_format scenes/generate replay replay/results replay/measure process server/store server/engine
server: base capture_format replay replay/results replay/measure process web server/store server/engine server/nightly
'
# The library whose folder a file is in: the longest that leads to it.
folder_of() {
  local found="" folder
  while IFS=: read -r folder _; do
    if [ -n "$folder" ] && [[ $1 == "$folder"/* ]] && [ ${#folder} -gt ${#found} ]; then found=$folder; fi
  done <<<"$layers"
  echo "$found"
}

failed=0 checked=0
while IFS=: read -r file include; do
  include=${include#*\"} include=${include%%\"*}
  own=$(folder_of "$file") other=$(folder_of "$include")
  [ -n "$own" ] || continue
  checked=$((checked + 1))
  if [ "$own" = "$other" ] || [[ $include == shaders/*.h ]]; then continue; fi
  allowed=$(grep "^$own:" <<<"$layers")
  if [ -z "$other" ] || ! [[ " ${allowed#*:} " == *" $other "* ]]; then
    echo "layers: $file includes $include" >&2
    failed=1
  fi
done < <(grep -r --include='*.[ch]pp' '^#include "' base capture_format recorder scenes replay process web server)
[ "$checked" -gt 500 ] || { echo "layers: only $checked includes found" >&2; failed=1; }
[ $failed = 1 ] || echo "layers: $checked includes"
exit $failed

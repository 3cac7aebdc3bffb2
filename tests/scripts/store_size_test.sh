#!/usr/bin/env bash
# bench/store.cpp in small: what it fills, reads and deletes leaves a store that is whole, with blobs inside and outside.
#   store_size_test.sh SUBPIXEL BENCH
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for outside in "" "--outside 1000"; do
  "$2" "$folder/data" --results 3000 --blobs 700 --night 100 $outside >"$folder/table"
  grep -q "^| a night's page | .* | 50 cells |" "$folder/table" || { cat "$folder/table"; exit 1; }
  "$1" store check --data "$folder/data" >"$folder/check" || { cat "$folder/check"; exit 1; }
  cat "$folder/check"
done
# The first ten nights went with the first gc, one with the `keep` after it, and as much the second time.
nights=$(sed -n 's/.* \([0-9]*\) nights.*/\1/p' "$folder/check")
[ "$nights" -lt 25 ] || { echo "$nights nights are left"; exit 1; }
grep -q " [1-9][0-9]* of them in files" "$folder/check"
if grep -q "^leftover" "$folder/check"; then exit 1; fi

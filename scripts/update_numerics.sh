#!/usr/bin/env bash
# Measures the tables of docs/numerics.md anew and puts them in place.
#   scripts/update_numerics.sh [cases] [features] [precision]     all of them without arguments
set -euo pipefail
cd "$(dirname "$0")/.."
page=docs/numerics.md
[ $# -gt 0 ] || set -- cases features precision
for part in "$@"; do
  table=$(mktemp)
  case $part in
    cases | features) build/release/bench/subpixel_numerics "$part" >"$table" ;;
    precision) build/release/bench/subpixel_precision >"$table" ;;
    *) echo "unknown table: $part" >&2 && exit 2 ;;
  esac
  awk -v part="$part" -v table="$table" '
    $0 == "<!-- end " part " -->" { skip = 0 }
    !skip { print }
    $0 == "<!-- begin " part " -->" {
      print ""
      while ((getline line < table) > 0) print line
      print ""
      skip = 1
    }' "$page" >"$page.new"
  mv "$page.new" "$page"
  rm "$table"
done

#!/usr/bin/env bash
# scripts/new_technique touches six files, four of them new, can be run again for another name and refuses what it can't do.
set -euo pipefail
source_dir=$(cd "$(dirname "$0")/../.." && pwd)
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
fail() { echo "FAILED: $*" >&2; exit 1; }
mkdir -p "$tree"/{replay/techniques,shaders/techniques,tests/technique,docs/techniques}
cp "$source_dir/README.md" "$tree/"
cp "$source_dir/replay/techniques/registry.cpp" "$tree/replay/techniques/"
export SUBPIXEL_ROOT=$tree
list() { (cd "$tree" && find . -type f -exec md5sum {} + | sort -k2); }

before=$(list)
"$source_dir/scripts/new_technique" tile_mean "Means of tiles" >/dev/null
after=$(list)
touched=$(comm -13 <(sort <<<"$before") <(sort <<<"$after") | wc -l)
new=$(comm -13 <(awk '{print $2}' <<<"$before" | sort) <(awk '{print $2}' <<<"$after" | sort) | wc -l)
[ "$touched" -le 6 ] || fail "$touched files touched"
[ "$new" = 4 ] || fail "$new new files"
"$source_dir/scripts/new_technique" second >/dev/null
for name in TileMean Second; do
  [ "$(grep -c "extern const Technique k$name;" "$tree/replay/techniques/registry.cpp")" = 1 ] || fail "k$name is not declared once"
  [ "$(grep -c "&k$name," "$tree/replay/techniques/registry.cpp")" = 1 ] || fail "k$name is not listed once"
done
[ "$(grep -c '^| `tile_mean` | Means of tiles |$' "$tree/README.md")" = 1 ] || fail "the README has no row"

before=$(list)
for name in "" Tile tile-mean 2tiles tile_ _tile tile_mean ../tile; do
  code=0
  "$source_dir/scripts/new_technique" "$name" >/dev/null 2>&1 || code=$?
  [ "$code" = 2 ] || fail "'$name' is taken, exit code $code"
done
[ "$before" = "$(list)" ] || fail "a refusal changed files"
echo ok

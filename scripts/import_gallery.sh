#!/usr/bin/env bash
# Imports every model in a folder, replays one small frame of each, and writes one page with picture, time, notices and errors.
#   scripts/import_gallery.sh DIR [OUT]     OUT: build/gallery unless given; the page is OUT/index.html, a table OUT/gallery.tsv
# Archives of models (.zip, Sweet Home 3D's .sh3f) are unpacked and their models taken, too.
#   SUBPIXEL_GALLERY_MOST=N   at most N models, spread evenly over all found
set -euo pipefail
cd "$(dirname "$0")/.."

[ $# -ge 1 ] && [ -d "$1" ] || { echo "usage: scripts/import_gallery.sh DIR [OUT]" >&2; exit 2; }
models=$(cd "$1" && pwd)
out=${2:-build/gallery}
subpixel=$PWD/build/release/subpixel
[ -x "$subpixel" ] || { echo "import_gallery: build/release/subpixel is not built yet" >&2; exit 2; }
mkdir -p "$out/pictures"
out=$(cd "$out" && pwd)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
kinds='gltf|glb|obj|stl|ply|off|dae|3ds|fbx|blend|x|3mf|ac|ase|b3d|bvh|cob|csm|dxf|hmp|ifc|irr|irrmesh|lwo|lws|lxo|md2|md3|md5mesh|mdl|ms3d|ndo|nff|ogex|q3o|q3s|raw|smd|ter|wrl|x3d|xgl|zgl|iqm|m3d|mesh.xml|pk3|sib|vta'

list_models() { find "$1" -type f -regextype posix-extended -iregex ".*\.($kinds)" | sort; }
seconds_since() { awk -v from="$1" -v to="$(date +%s.%N)" 'BEGIN { printf "%.2f", to - from }'; }
escaped() { sed 's/&/\&amp;/g; s/</\&lt;/g; s/>/\&gt;/g; s/"/\&quot;/g'; }

# Archives next to each other may have members of one name.
while IFS= read -r archive; do
  folder=$scratch/archives/$(basename "$archive")
  mkdir -p "$folder"
  python3 -m zipfile -e "$archive" "$folder" || echo "import_gallery: $archive can't be unpacked" >&2
done < <(find "$models" -type f -regextype posix-extended -iregex '.*\.(zip|sh3f)' | sort)
mapfile -t all < <(list_models "$models"; [ ! -d "$scratch/archives" ] || list_models "$scratch/archives")
most=${SUBPIXEL_GALLERY_MOST:-${#all[@]}}
[ "$most" -le ${#all[@]} ] || most=${#all[@]}

page=$out/index.html
table=$out/gallery.tsv
cards=$scratch/cards
: >"$cards"
printf 'model\toutcome\timport_s\treplay_s\ttriangles\tsaid\n' >"$table"
imported=0 refused=0 failed=0
for ((n = 0; n < most; ++n)); do
  model=${all[$((n * ${#all[@]} / most))]}
  name=${model#"$models/"}
  name=${name#"$scratch/archives/"}
  picture=pictures/$(printf '%04d' "$n").png
  capture=$scratch/model.spcap
  rm -rf "$capture" "$scratch/replay"
  started=$(date +%s.%N)
  code=0
  "$subpixel" import "$model" "$capture" --frames 1 --size 320x180 >"$scratch/out" 2>"$scratch/err" || code=$?
  import_s=$(seconds_since "$started") replay_s='' triangles='' said=''
  if [ "$code" = 0 ]; then
    triangles=$(sed -n 's/.* \([0-9]*\) triangles.*/\1/p' "$scratch/out")
    said=$("$subpixel" info "$capture" --json | python3 -c 'import json, sys
print("; ".join(json.load(sys.stdin).get("notices", [])))')
    started=$(date +%s.%N)
    "$subpixel" replay "$capture" --techniques msaa --samples 8 --repeat 1 --reference-samples 0 --out "$scratch/replay" \
      >"$scratch/out" 2>"$scratch/err" || code=$?
    replay_s=$(seconds_since "$started")
    image=$(find "$scratch/replay" -name '*.png' ! -name '*shading*' ! -name '*error*' 2>/dev/null | sort | sed -n 1p)
    if [ "$code" = 0 ] && [ -n "$image" ]; then cp "$image" "$out/$picture"; else [ "$code" != 0 ] || code=1; fi
  fi
  lines=$(wc -l <"$scratch/err")
  if [ "$code" = 0 ]; then
    outcome=imported; imported=$((imported + 1))
  elif [ "$code" = 3 ] && [ "$lines" = 1 ]; then
    outcome=refused; refused=$((refused + 1)); said=$(cat "$scratch/err")
  else  # a signal, another exit code, more than a line: ours to mend
    outcome="failed ($code)"; failed=$((failed + 1)); said=$(tr '\n' ' ' <"$scratch/err")
  fi
  said=${said//"$models/"/}
  said=${said//"$scratch/archives/"/}
  printf '%s\t%s\t%s\t%s\t%s\t%s\n' "$name" "$outcome" "$import_s" "$replay_s" "$triangles" "${said//$'\t'/ }" >>"$table"
  {
    echo "<figure class=\"${outcome%% *}\">"
    if [ "$outcome" = imported ]; then echo "<img src=\"$picture\" width=\"320\" height=\"180\" alt=\"\" loading=\"lazy\">"; fi
    echo "<figcaption><b>$(printf '%s' "$name" | escaped)</b> $outcome, ${triangles:+$triangles triangles, }import ${import_s} s${replay_s:+, replay ${replay_s} s}"
    echo "<br>$(printf '%s' "$said" | escaped)</figcaption></figure>"
  } >>"$cards"
  printf '%4d/%d  %-10s %s\n' $((n + 1)) "$most" "$outcome" "$name"
done
{
  cat <<'HTML'
<!doctype html>
<html lang="en">
<meta charset="utf-8">
<title>Imported models</title>
<style>
  body { font: 13px/1.35 sans-serif; margin: 16px; background: #16181c; color: #d8dade }
  main { display: grid; grid-template-columns: repeat(auto-fill, 328px); gap: 12px }
  figure { margin: 0; padding: 4px; background: #22252b; overflow-wrap: anywhere }
  figure.refused { border-left: 3px solid #c9a227 }
  figure.failed { border-left: 3px solid #d04a4a }
</style>
HTML
  echo "<h1>$imported imported, $refused refused with a reason, $failed failed</h1>"
  echo "<main>"
  cat "$cards"
  echo "</main>"
} >"$page"
echo "$imported imported, $refused refused with a reason, $failed failed; $page"
[ "$failed" = 0 ]

#!/usr/bin/env bash
# Does the nightly see what it is there to see? Approves a night of the sources as they are, then runs nights that nothing
# has changed for (no alarm may come), then one night for each seeded mutation of a shader or of host code.
#   tests/nightly/mutations.sh FOLDER [NIGHTS]    NIGHTS without a change, default 10
# FOLDER gets a copy of the sources with a build of its own, the data folder, and one summary for each night.
# RUN is put before every build and night (RUN="nice"). Prints a Markdown table; exit code 1 when an unchanged night
# alarmed or a mutation does not apply.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mkdir -p "$1" && cd "$1" && pwd)
nights=${2:-10}
run=${RUN:-}
sources=$folder/sources
subpixel=$sources/build/release/subpixel
config=$root/tests/nightly/mutations.json

# name | file | sed expression | what it does
mutations=(
  "roughness floor|shaders/include/brdf.glsl|s/kRoughnessFloor = 0.089/kRoughnessFloor = 0.12/|highlights of all techniques and of the reference get wider"
  "Blinn-Phong lobe|shaders/include/brdf.glsl|s/(b.exponent + 8.0) \* (0.125/(b.exponent + 2.0) * (0.125/|the lobe's normalisation, which only shading=blinn_phong uses"
  "top-left rule|shaders/include/coverage.glsl|s/return along.y < 0 || (along.y == 0 \&\& along.x > 0);/return along.y < 0;/|samples on a level edge belong to no triangle"
  "merged depth|shaders/techniques/streaming/compress.glsl|s/merged.depth = min(a.depth, b.depth)/merged.depth = max(a.depth, b.depth)/|a merged surface keeps the farther depth"
  "albedo mean|shaders/include/blending.glsl|s/precise float mean = root_a \* root_a \* w.a + root_b \* root_b \* w.b;/precise float linear = root_a * w.a + root_b * w.b, mean = linear * linear;/|albedo is averaged as stored, not as linear values"
  "depth reach|shaders/techniques/simple_complex/classification.glsl|s/abs(depths\[i\] - depth) > reach/abs(depths[i] - depth) > 2.0 * reach/|more pixels count as simple"
  "equal depths|shaders/frontend/visibility_small.frag|s/own < triangles\[q\]\[i\]/own > triangles[q][i]/|of equal depths of small triangles the last submitted stays"
  "shared depth|shaders/techniques/dcaa/merge.glsl|s/share >= 0.0 \&\& score/share >= 0.2 \&\& score/|surfaces merge only when their depths overlap by a fifth"
  "joined part|shaders/techniques/dcaa/merge.glsl|s/^    if (kNearest) gone.coverage = leaving_shows;//|a surface that joins another brings samples of which it shows nothing"
  "edge tolerance|shaders/techniques/fxaa/filter.frag|s/tolerance = 0.25 \* abs(other - m)/tolerance = 0.3 * abs(other - m)/|where an edge's end is seen"
  "slower filter|shaders/techniques/fxaa/filter.frag|s/^  vec4 own = texelFetch(values, pixel, 0);/  float idle = m; for (uint i = 0u; i < push.steps * 400u; ++i) idle = fract(idle * 1.7 + 0.3);\n  vec4 own = texelFetch(values, pixel, 0) + vec4(vec3(idle * 1e-35), 0.0);/|the same image from a shader that takes far longer"
  "layout entry|replay/techniques/streaming.cpp|s/return {{\"depth\", 32 \* n}, {\"count word\", 32}/return {{\"depth\", 32 * n}, {\"count word\", 24}/|one byte a pixel less is reported"
  "mean square|replay/measure/metrics.cpp|s/a.height \* colour);/a.height * 4);/|the error of equal images is reported a quarter lower"
  "shadow cascades|replay/scene/shadow_fit.cpp|s/farthest \/ std::pow(kReachRatio/farthest \/ std::pow(1.1 * kReachRatio/|shadow maps end elsewhere, for the reference too"
  "large triangles|shaders/include/coverage.glsl|s/abs(rough) < 2080374784.0/abs(rough) < 3000000000.0/|edges of large triangles are whole numbers where these no longer fit 32 bits"
)

say() { printf '%s\n' "$*" >&2; }

copy_sources() {
  mkdir -p "$sources"
  (cd "$root" && tar cf - --exclude=./build --exclude=./.git --exclude=node_modules --exclude=./demo .) | tar xf - -C "$sources"
}

build() {
  [ -e "$sources/build/release/build.ninja" ] || (cd "$sources" && $run cmake --preset release >"$folder/configure.log" 2>&1)
  (cd "$sources" && $run ninja -C build/release subpixel >"$folder/build.log" 2>&1)
}

# night NAME: prints the exit code; the summary is NAME.json.
night() {
  local code=0
  $run "$subpixel" nightly --config "$config" --data "$folder/data" --json "$folder/$1.json" --markdown "$folder/$1.md" \
    >/dev/null 2>"$folder/$1.log" || code=$?
  echo "$code"
}

# The gates that failed, each with its number of cells.
failed_gates() {
  python3 - "$folder/$1.json" <<'PY'
import collections, json, sys
night = json.load(open(sys.argv[1]))
gates = collections.Counter(g['gate'] for c in night['cells'] for g in c['gates'] if g['outcome'] == 'failed')
cells = sum(1 for c in night['cells'] if c['status'] in ('failed', 'missing'))
print(f"{cells} of {len(night['cells'])} cells: " + ', '.join(f'{g} {n}' for g, n in gates.most_common()) if cells else '-')
PY
}

rm -rf "$folder/data"
copy_sources
build
say "baseline"
night baseline >/dev/null
"$subpixel" baseline set mutations --data "$folder/data" >/dev/null

alarms=0
for i in $(seq "$nights"); do
  code=$(night "unchanged$i")
  say "unchanged $i: exit code $code"
  [ "$code" = 0 ] || { alarms=$((alarms + 1)); failed_gates "unchanged$i" >&2; }
done

table=$folder/table.md
{
  echo "| mutation | file | what it does | caught | by |"
  echo "| --- | --- | --- | --- | --- |"
} >"$table"
wrong=0
for mutation in "${mutations[@]}"; do
  # The expression has no bar but in the top-left rule's "||", which is put back together.
  name=${mutation%%|*}; rest=${mutation#*|}
  file=${rest%%|*}; rest=${rest#*|}
  what=${rest##*|}; expression=${rest%|*}
  sed -i "$expression" "$sources/$file"
  if cmp -s "$sources/$file" "$root/$file"; then
    say "$name: does not apply"
    wrong=1
    continue
  fi
  if build; then
    code=$(night "mutation_${name// /_}")
    caught=$([ "$code" = 1 ] && echo yes || echo no)
    by=$(failed_gates "mutation_${name// /_}")
  else
    caught="does not compile" by="-"
  fi
  say "$name: $caught, $by"
  echo "| $name | \`$file\` | $what | $caught | $by |" >>"$table"
  cp "$root/$file" "$sources/$file"
done
echo "unchanged nights: $nights, alarms: $alarms"
cat "$table"
[ "$alarms" = 0 ] && [ "$wrong" = 0 ]

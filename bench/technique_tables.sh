#!/usr/bin/env bash
# The runs behind the tables of docs/techniques that the report (bench/report) does not have: settings of agaa, hybrid and
# dcaa at 640x360 against 256 samples, scenes at 1920x1080 against 128. Errors and counts, no times: the machine may be busy.
# A quarter of an hour on 2 quiet cores; goes on where it was.
#   bench/technique_tables.sh build/release/subpixel FOLDER [CACHE]
# FOLDER gets NAME.json for each capture, for bench/table.py; CACHE holds references (build/report/references has those of the report).
set -euo pipefail
subpixel=$(realpath "$1") folder=$(realpath -m "$2") cache=${3:+$(realpath -m "$3")}
root=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$folder/captures"

agaa="agaa:aggregates=1..4,agaa:ndf=sggx,agaa:storage=float,agaa:ndf=lean,agaa:ndf=lean:storage=float,agaa:light_variance=true"
agaa+=",agaa:shadow=samples,agaa:aggregates=3:samples=4|16|32,agaa:separation=0.05|0.2|1,agaa:length=0.02|1|10,agaa:shadow_taps=1|8"
hybrid="hybrid:surfaces=3|8,hybrid:second_merge=overlapping,hybrid:normals=mean|sggx,hybrid:shadow_taps=1,hybrid:merge_weight=coverage"
hybrid+=",hybrid:shown_only=false:least_shown=0"
dcaa="dcaa:second_merge=none,dcaa:keep_front=false,dcaa:coverage=exact,dcaa:depth_bits=16"
fails="msaa:samples=8,agaa:aggregates=1..4,agaa:ndf=sggx:aggregates=1..4"
figure8="msaa:samples=8,dcaa:surfaces=1|2|3|4|6|8,dcaa:facet_normal=2x8|3x8|3x32,dcaa:depth_bits=16|20|32,dcaa:samples=16|32"

# run NAME CAPTURE SIZE REFERENCE TECHNIQUES
run() {
  local name=$1 capture=$2 size=$3 reference=$4 techniques=$5
  [ -s "$folder/$name.json" ] && return
  echo "$name"
  "$subpixel" replay "$capture" --size "$size" --frames 0-0 --repeat 1 --reference-samples "$reference" --techniques "$techniques" \
    ${cache:+--cache "$cache"} --out "$folder/out" --json "$folder/part.json" >/dev/null
  mv "$folder/part.json" "$folder/$name.json"
  rm -rf "$folder/out"
}
# capture SCENE: $file is its, made when it is not there
capture() {
  file=$folder/captures/$1.spcap
  [ -s "$file" ] && return
  if [ "$1" = park ]; then
    "$subpixel" import "$root/scenes/described/park.json" "$file" --frames 1 >/dev/null
  else
    "$subpixel" generate "$1" "$file" --frames 1 >/dev/null
  fi
}
for scene in grass fur tubes bamboo foliage city arcade plant cathedral park; do
  capture "$scene"
  run "$scene" "$file" 640x360 256 "msaa:samples=8|4|16|32,$agaa,$hybrid,$dcaa"
done
for scene in agaa_correlation agaa_hairs agaa_railings; do
  capture "$scene"
  run "$scene" "$file" 640x360 256 "$fails"
done
# Scenes that the report leaves out at this size.
for scene in fur tubes foliage plant park; do
  capture "$scene"
  run "${scene}_1920x1080" "$file" 1920x1080 128 \
    "msaa:samples=8,forward:samples=8,sbaa:surfaces=4,dcaa,dcaa:second_merge=nearest,hybrid"
done
capture city
run city_figure8 "$file" 320x180 128 "$figure8"

#!/usr/bin/env bash
# Makes the figures and prints the numbers of docs/scenes.md and of docs/techniques/{forward,fxaa,simple_complex,sbaa}.md.
#   docs/images/baselines.sh SUBPIXEL FOLDER     FOLDER keeps captures, references and results; a second run is quick
# Needs oiiotool (package openimageio-tools) and, for the park, the package sweethome3d-furniture.
set -euo pipefail
subpixel=$(realpath "$1")
mkdir -p "$2"
folder=$(realpath "$2")
cd "$(dirname "$0")/../.."
images=$PWD/docs/images
scenes=(grass fur tubes bamboo foliage city arcade park plant cathedral)
techniques="noaa,fxaa,forward:samples=4|8,msaa:samples=4|8,simple_complex:samples=4|8"
techniques+=",sbaa:surfaces=2|4|6|8,sbaa:mode=id:surfaces=2|4|8"

for scene in "${scenes[@]}"; do
  capture=$folder/$scene.spcap
  if [ "$scene" = park ]; then make=(import scenes/described/park.json); else make=(generate "$scene"); fi
  [ -e "$capture" ] || "$subpixel" "${make[@]}" "$capture" --frames 1 --size 640x360
  [ -e "$folder/$scene/results.json" ] ||
    "$subpixel" replay "$capture" --techniques "$techniques" --repeat 1 --out "$folder/$scene" >"$folder/$scene.txt"
  echo "$scene"
  sed -n '/^technique/,/^images/p' "$folder/$scene.txt"
done

# panels OUT.png COLUMNSxROWS SCENE WIDTHxHEIGHT+X+Y IMAGE...: cut from images of a scene's frame, twice as large.
panels() {
  local out=$1 grid=$2 scene=$3 cut=$4 list=()
  shift 4
  for image in "$@"; do
    list+=("$folder/$scene/frame0000_$image.png" --cut "$cut" --resize:filter=box "$((${cut%%x*} * 2))x0")
  done
  oiiotool "${list[@]}" --mosaic:pad=4 "$grid" --nosoftwareattrib --eraseattrib ".*" --compression zip:9 -o "$out"
}

sheet=()
for scene in "${scenes[@]}"; do
  sheet+=("$folder/$scene/frame0000_reference0.png" --resize:filter=blackman-harris 240x135)
done
mkdir -p "$images"/{scenes,forward,fxaa,simple_complex,sbaa}
oiiotool "${sheet[@]}" --mosaic:pad=4 5x2 --nosoftwareattrib --eraseattrib ".*" -d uint8 --compression zip:9 -o "$images/scenes/contact_sheet.png"
panels "$images/forward/bamboo.png" 4x1 bamboo 160x90+330+60 03_forward 03_forward_shading 03_forward_error 05_msaa_error
panels "$images/forward/arcade.png" 4x1 arcade 160x90+10+100 03_forward 03_forward_shading 03_forward_error 05_msaa_error
panels "$images/fxaa/city.png" 3x2 city 160x90+150+0 \
  00_noaa 01_fxaa reference0 01_fxaa_changed 01_fxaa_error 05_msaa_error
for scene in arcade tubes; do
  panels "$images/simple_complex/$scene.png" 4x1 "$scene" 160x90+300+120 \
    07_simple_complex 07_simple_complex_complex 07_simple_complex_shading 07_simple_complex_error
done
panels "$images/sbaa/city.png" 3x2 city 160x90+470+20 \
  reference0 14_sbaa 09_sbaa 09_sbaa_surfaces 14_sbaa_error 09_sbaa_error
panels "$images/sbaa/grass.png" 3x2 grass 160x90+300+200 \
  reference0 09_sbaa 08_sbaa 08_sbaa_dropped 09_sbaa_error 08_sbaa_error

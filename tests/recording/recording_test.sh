#!/usr/bin/env bash
# Records the applications beside this script and vkcube under RenderDoc, imports their frames, and holds the depth of
# what Subpixel replays against the depth that RenderDoc replays.
#   recording_test.sh SUBPIXEL APPLICATION...     exit code 77 where something that is needed is missing
set -euo pipefail
subpixel=$1; shift
root=$(cd "$(dirname "$0")/../.." && pwd)
python=${SUBPIXEL_PYTHON:-/usr/bin/python3}
skip() { echo "skipped: $*"; exit 77; }
SUBPIXEL=$subpixel "$python" -B "$root/tests/recording/export_test.py"  # needs nothing of what may be missing
"$python" -c 'import renderdoc' 2>/dev/null || skip "$python has no module renderdoc (Debian: python3-renderdoc)"
command -v xvfb-run >/dev/null || skip "no xvfb-run (Debian: xvfb, xauth)"
[ $# -gt 0 ] || skip "the applications are not built (Debian: libgl-dev, libx11-dev, libvulkan-dev)"

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export SUBPIXEL=$subpixel PYTHONPATH=$root/python PYTHONDONTWRITEBYTECODE=1 LIBGL_ALWAYS_SOFTWARE=1
failures=0
failed() { echo "FAILED: $*"; failures=$((failures + 1)); }
value() { "$python" -c 'import json, sys; print(json.load(sys.stdin)[sys.argv[1]])' "$1"; }

# expect_depth NAME LEAST_PERCENT: of the pixels that either side covers, of frame 0
expect_depth() {
  local said share
  said=$("$python" -m subpixel_renderdoc.depth "$folder/$1/frame_0.rdc" "$folder/$1.spcap" 0 "$subpixel" \
    "$folder/$1.depth")
  share=$("$python" -c 'import json, sys
s = json.loads(sys.argv[1]); print(100 * s["agree"] / (100 - s["neither"]))' "$said")
  echo "$1: $share % of the pixels at RenderDoc's depth: $said"
  "$python" -c 'import sys; sys.exit(float(sys.argv[1]) < float(sys.argv[2]))' "$share" "$2" ||
    failed "$1: $share % of the pixels have RenderDoc's depth"
}

programs=("$@")
if vkcube=$(command -v vkcube); then programs+=("$vkcube"); fi
for program in "${programs[@]}"; do
  name=$(basename "$program")
  "$root/scripts/record_app.sh" --frame 5 --frames 2 --size 640x480 --keep "$folder/$name" "$folder/$name.spcap" \
    "$program" || { failed "$name is not recorded"; continue; }
  "$subpixel" validate "$folder/$name.spcap" || failed "$name is not valid"
  "$subpixel" info --json "$folder/$name.spcap" >"$folder/$name.json"
  [ "$(value frame_count <"$folder/$name.json")" = 2 ] || failed "$name has not two frames"
  expect_depth "$name" 99
done

# The service, whose import may reach nothing but the frame, makes the same bytes of it as the command line, and that the
# same with a display and without.
"$subpixel" serve --data "$folder/service" --listen 127.0.0.1:0 >"$folder/service.log" 2>&1 &
service=$!
trap 'kill $service 2>/dev/null || :; rm -rf "$folder"' EXIT
for program in "${programs[@]}"; do
  name=$(basename "$program")
  frame=$folder/$name/frame_0.rdc
  [ -e "$frame" ] || continue
  "$subpixel" import "$frame" "$folder/frame_0.spcap" || { failed "$name: a frame is not imported"; continue; }
  "$python" - "$folder" "$frame" <<'PY' || failed "$name: not imported by the service as by the command line"
import json, pathlib, re, sys, time, urllib.request
folder, frame = map(pathlib.Path, sys.argv[1:])
for _ in range(300):
    said = re.search(r"http://\S+", (folder / "service.log").read_text())
    if said:
        break
    time.sleep(0.1)
address = said.group() + "/api/captures"
try:
    with urllib.request.urlopen(urllib.request.Request(address + "?name=frame_0.rdc", frame.read_bytes())) as answer:
        capture = json.load(answer)
except urllib.error.HTTPError as error:
    sys.exit(error.read().decode())
with urllib.request.urlopen("{}/{}/file".format(address, capture["hash"])) as answer:
    theirs = answer.read()
assert theirs == (folder / "frame_0.spcap").read_bytes(), "other bytes"
PY
  xvfb-run -a "$subpixel" import --on-display "$frame" "$folder/on_display.spcap" || failed "$name: --on-display"
  cmp "$folder/frame_0.spcap" "$folder/on_display.spcap" || failed "$name: with a display it is another capture"
done

# One scene by two APIs: the same triangles, textures and features.
if [ -e "$folder/gl_application.json" ] && [ -e "$folder/vulkan_application.json" ]; then
  for key in draws triangles materials features width height; do
    a=$(value $key <"$folder/gl_application.json") b=$(value $key <"$folder/vulkan_application.json")
    [ "$a" = "$b" ] || failed "$key: OpenGL $a, Vulkan $b"
  done
  # Four triangles of the ground are composed with the decal over them: blue on the right of each 32 texels.
  if "$python" -c 'import numpy' 2>/dev/null; then
    "$python" - "$folder/gl_application.spcap" "$folder/vulkan_application.spcap" <<'PY' || failed "the decal is wrong"
import sys
import subpixel_capture as spcap

def composed(path):
    capture = spcap.read(path)
    draws = [d for d in capture.frames[0].draws if d.name.startswith("composed layers")]
    assert [d.index_count for d in draws] == [12], [(d.name, d.index_count) for d in draws]
    texture = capture.textures[capture.materials[draws[0].material].base_colour_texture]
    texels = [texture.bytes[i:i + 3] for i in range(0, len(texture.bytes), 4)]
    blue, ground = (sum(all(abs(a - b) < 30 for a, b in zip(t, wanted)) for t in texels)
                    for wanted in ((20, 30, 250), (90, 120, 160)))
    print("{}: {} texels, {} blue, {} of the ground's".format(path, len(texels), blue, ground))
    assert blue > 100 and ground > 50
    return texture

a, b = (composed(path) for path in sys.argv[1:])
assert (a.width, a.height) == (b.width, b.height)
assert max(abs(x - y) for x, y in zip(a.bytes, b.bytes)) <= 2
PY
  fi
  # Ground 288, cubes 7 x 12, tube 192, fan 16, cards 8.
  [ "$(value triangles <"$folder/gl_application.json")" = 588 ] || failed "not 588 triangles"
  notices=$("$subpixel" info "$folder/gl_application.spcap")
  [[ $notices == *"left out: writes no depth"* ]] || failed "no word of the pane: $notices"
fi

# What can't be read is refused in one line, and nothing is left.
mkdir "$folder/out"
refused() {
  local words=$1 said code=0; shift
  said=$("$@" 2>&1 >/dev/null) || code=$?
  [ $code = 3 ] || failed "exit code $code instead of 3: $*: $said"
  [ "$(wc -l <<<"$said")" = 1 ] || failed "more than a line: $said"
  [[ $said == *"$words"* ]] || failed "'$words' is not in: $said"
  [ -z "$(ls -A "$folder/out")" ] || { failed "left behind: $(ls -A "$folder/out")"; rm -rf "${folder:?}/out/"*; }
}
rdc=$folder/$(basename "$1")/frame_0.rdc
if [ -e "$rdc" ]; then
  head -c 100 /dev/urandom >"$folder/noise.rdc"
  head -c $(($(stat -c %s "$rdc") / 2)) "$rdc" >"$folder/cut.rdc"
  : >"$folder/empty.rdc"
  refused "the RenderDoc capture can't be read" "$subpixel" import "$folder/noise.rdc" "$folder/out/x.spcap"
  refused "can't be" "$subpixel" import "$folder/cut.rdc" "$folder/out/x.spcap"
  refused "the RenderDoc capture can't be read" "$subpixel" import "$folder/empty.rdc" "$folder/out/x.spcap"
  refused "can't be opened" "$subpixel" import "$folder/missing.rdc" "$folder/out/x.spcap"
  # A file cut anywhere: within the header, after it, a byte before the end; and one whose driver is another's.
  for bytes in 3 8 40 200 $(($(stat -c %s "$rdc") - 1)); do
    head -c "$bytes" "$rdc" >"$folder/cut.rdc"
    refused "can't be" "$subpixel" import "$folder/cut.rdc" "$folder/out/x.spcap"
  done
  "$python" - "$rdc" "$folder/driver.rdc" <<'PY'
import re, sys
data = open(sys.argv[1], "rb").read()
# Four bytes of a driver's number and one of a length stand before its name: 1 is Direct3D 11's.
made, count = re.subn(rb"[\x02\x08]\0\0\0([\x06\x07])(OpenGL|Vulkan)",
                      lambda found: b"\1\0\0\0" + found.group(1) + b"D3D11\0", data, count=1)
assert count == 1
open(sys.argv[2], "wb").write(made)
PY
  refused "this machine cannot replay captures of D3D11" "$subpixel" import "$folder/driver.rdc" "$folder/out/x.spcap"
  # A frame that is refused after others were taken leaves nothing either; the others' progress is not of the error.
  last_line() { "$@" 2>&1 >/dev/null | tail -n 1 >&2; return "${PIPESTATUS[0]}"; }
  refused "can't be" last_line "$subpixel" import "$rdc" "$folder/out/x.spcap" --next "$folder/noise.rdc"
  refused "no draw has a depth target among the chosen ones" "$subpixel" import "$rdc" "$folder/out/x.spcap" --target 1
  refused "no draw has a depth target" "$subpixel" import "$rdc" "$folder/out/x.spcap" --events 0-1
  refused "longer than 1 s" env SUBPIXEL_PYTHON="$root/tests/recording/slow_python.sh" \
    "$subpixel" import "$rdc" "$folder/out/x.spcap" --limit-seconds 1
  refused "crashed" env SUBPIXEL_PYTHON="$root/tests/recording/crashing_python.sh" \
    "$subpixel" import "$rdc" "$folder/out/x.spcap"
  refused "no module renderdoc" env SUBPIXEL_PYTHON="$root/tests/recording/python_without_renderdoc.sh" \
    "$subpixel" import "$rdc" "$folder/out/x.spcap"
fi

# A program that shows nothing, and one that ends at once.
refused "0 of 1 frames came within 2 s; RenderDoc saw it draw by no interface" xvfb-run -a "$python" \
  -m subpixel_renderdoc.record --frame 0 --timeout 2 "$folder/out/x" sleep 30
refused "there is no such program" "$python" -m subpixel_renderdoc.record "$folder/out/x" no-such-program

[ "$failures" = 0 ] || { echo "$failures failures"; exit 1; }

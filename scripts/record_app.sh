#!/usr/bin/env bash
# Records frames of an application under RenderDoc, without a screen, and imports them as one capture.
#   scripts/record_app.sh [options] OUT.spcap PROGRAM ARGUMENTS...
#     --frame N        number of the first frame, from 0; or
#     --delay SECONDS  after the start (default 10)
#     --frames COUNT   how many consecutive ones (default 1)
#     --timeout SECONDS  to wait for them (default 120)
#     --size WxH       of the screen that is made (default 1280x720)
#     --import OPTION  handed on to `subpixel import`, such as --import=--sun=-0.3,-0.9,-0.4; may be repeated
#     --keep FOLDER    keep the .rdc files there
# SUBPIXEL is the program (default build/release/subpixel). OpenGL is drawn by the CPU unless LIBGL_ALWAYS_SOFTWARE=0.
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)

usage() { sed -n '2,/^set /s/^# \{0,1\}//p' "$0" | sed '/^set /d' >&2; exit 2; }
fail() { printf 'record_app: %s\n' "$*" >&2; exit 3; }

when=(--delay 10) frames=1 timeout=120 size=1280x720 import=() keep=
while [ $# -gt 0 ]; do
  case "$1" in
    --frame) when=(--frame "$2"); shift 2 ;;
    --delay) when=(--delay "$2"); shift 2 ;;
    --frames) frames=$2; shift 2 ;;
    --timeout) timeout=$2; shift 2 ;;
    --size) size=$2; shift 2 ;;
    --import=*) import+=("${1#--import=}"); shift ;;
    --keep) keep=$2; shift 2 ;;
    --*) usage ;;
    *) break ;;
  esac
done
[ $# -ge 2 ] || usage
out=$1; shift
subpixel=${SUBPIXEL:-$here/build/release/subpixel}
python=${SUBPIXEL_PYTHON:-/usr/bin/python3}
[ -x "$subpixel" ] || fail "$subpixel is not built"
command -v xvfb-run >/dev/null || fail "xvfb-run is missing; Debian's packages are xvfb and xauth"
"$python" -c 'import renderdoc' 2>/dev/null ||
  fail "$python has no module renderdoc; Debian's package is python3-renderdoc"

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export LIBGL_ALWAYS_SOFTWARE=${LIBGL_ALWAYS_SOFTWARE:-1} SDL_AUDIODRIVER=${SDL_AUDIODRIVER:-dummy}
# What the application prints, colours too, is in between what the recorder prints: the files are found by their names.
PYTHONPATH=$here/python PYTHONDONTWRITEBYTECODE=1 xvfb-run -a -s "-screen 0 ${size}x24" "$python" \
  -m subpixel_renderdoc.record "${when[@]}" --frames "$frames" --timeout "$timeout" "$folder/frame" "$@" >&2
mapfile -t files < <(find "$folder" -name 'frame_*.rdc' | sort -V)
[ ${#files[@]} -gt 0 ] || fail "no frame was captured"
next=()
for file in "${files[@]:1}"; do next+=(--next "$file"); done
if [ -n "$keep" ]; then mkdir -p "$keep"; cp "${files[@]}" "$keep/"; fi
"$subpixel" import "${files[0]}" "$out" "${next[@]}" "${import[@]}"

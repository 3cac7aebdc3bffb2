#!/usr/bin/env bash
# Records frames of games, imports them and compares depths with RenderDoc's, by hand or at night: takes minutes, and
# packages that this script asks for but does not install. What is seen on them: docs/games.md.
#   scripts/record_games.sh OUT_FOLDER [warzone_vulkan|warzone_opengl|black_forest|lighthouse|courtyard ...]
# (default: all). Warzone 2100 (Debian: warzone2100; GPL-2+, art CC0-1.0, CC-BY-SA-3.0, GPL-2+) by Vulkan and by OpenGL:
# one scene, two APIs. Two tracks of SuperTuxKart (Debian: supertuxkart; GPL-3+, art CC-BY-SA-3.0 and others) by OpenGL,
# of lighthouse 30 consecutive frames in one capture. A courtyard of our own in Godot 3 (Debian: godot3-runner) by OpenGL.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
[ $# -ge 1 ] || { sed -n '2,7s/^# \{0,1\}//p' "$0" >&2; exit 2; }
mkdir -p "$1"
out=$(cd "$1" && pwd); shift
games=("${@:-warzone_vulkan}"); [ $# -gt 0 ] || games=(warzone_vulkan warzone_opengl black_forest lighthouse courtyard)
export SUBPIXEL=${SUBPIXEL:-$root/build/release/subpixel} PATH=$PATH:/usr/games
python=${SUBPIXEL_PYTHON:-/usr/bin/python3}

# record NAME FRAMES OPTIONS... -- PROGRAM ARGUMENTS...
record() {
  local name=$1 frames=$2 options=(); shift 2
  while [ "$1" != -- ]; do options+=("$1"); shift; done
  shift
  command -v "$1" >/dev/null || { echo "$name: left out: no $1 here (Debian's package of that name)"; return 0; }
  "$root/scripts/record_app.sh" --frames "$frames" "${options[@]}" --keep "$out/$name" "$out/$name.spcap" "$@" \
    >"$out/$name.log" 2>&1 || { echo "$name: not recorded: $(tail -n 1 "$out/$name.log")"; return 0; }
  echo "$name: $("$SUBPIXEL" info "$out/$name.spcap" | grep -E '^(draws|triangles) ' | tr -s ' \n' ' ')"
  printf '%s: per cent of the pixels: ' "$name"
  PYTHONPATH=$root/python PYTHONDONTWRITEBYTECODE=1 LIBGL_ALWAYS_SOFTWARE=1 "$python" \
    -m subpixel_renderdoc.depth "$out/$name/frame_0.rdc" "$out/$name.spcap" 0 "$SUBPIXEL" "$out/$name.depth" ||
    echo "not compared"  # the other games are recorded all the same
}

for game in "${games[@]}"; do
  case "$game" in
    warzone_*)
      settings=$out/$game.settings
      rm -rf "$settings"; mkdir -p "$settings"
      record "$game" 1 --delay 75 --timeout 600 -- warzone2100 --gfxbackend="${game#warzone_}" --window \
        --resolution=1280x720 --nosound --game=CAM_1A --configdir="$settings" ;;
    black_forest | lighthouse)
      # Without the lights that are worked out a minute for each track where the CPU draws; textures as texels and
      # without anisotropy, so that alpha tests cut as a replay's do.
      settings=$out/supertuxkart.settings/supertuxkart/config-0.10
      mkdir -p "$settings"
      [ -e "$settings/config.xml" ] || cat >"$settings/config.xml" <<'XML'
<?xml version="1.0"?>
<stkconfig version="8">
  <Video width="800" height="450" fullscreen="false" enable_dynamic_lights="false" enable_texture_compression="false" />
  <GFX anisotropic="0" shadows_resolution="0" light_scatter="false" />
</stkconfig>
XML
      frames=1; [ "$game" = black_forest ] || frames=30
      XDG_CONFIG_HOME=$out/supertuxkart.settings record "$game" "$frames" --delay 100 --timeout 900 --size 800x450 -- \
        supertuxkart --windowed --screensize=800x450 --no-start-screen --track="$game" --numkarts=3 --mode=1 \
        --profile-laps=5 --no-sound ;;
    courtyard)
      HOME=$out record "$game" 1 --frame 40 --timeout 600 -- godot3-runner --path "$root/tests/recording/godot" \
        --video-driver GLES3 --audio-driver Dummy ;;
    *) echo "no such game: $game" >&2; exit 2 ;;
  esac
done

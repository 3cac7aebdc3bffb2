#!/usr/bin/env bash
# clang-format over all C++ sources, then clang-tidy for as long as SUBPIXEL_TIDY_SECONDS allows (default 240; "all": no
# limit). A file that passed is not checked again until it, a header or the configuration changes, so what one run does
# not reach the next one does.
set -euo pipefail
cd "$(dirname "$0")/.."

limit=${SUBPIXEL_TIDY_SECONDS:-240}
folders=(base capture_format recorder scenes replay process web server cli tests bench)

mapfile -t sources < <(find "${folders[@]}" -name '*.cpp' -o -name '*.hpp' -o -name '*.h' -o -name '*.c' | sort)
# Other versions break some lines elsewhere.
formatter=14
found=$(clang-format --version | sed 's/.*version \([0-9]*\).*/\1/')
if [ "$found" = "$formatter" ]; then
  echo "clang-format: ${#sources[@]} files"
  clang-format --dry-run -Werror "${sources[@]}"
else
  echo "clang-format: left out: the sources are as version $formatter has them, and this is $found"
fi

[ "$limit" = 0 ] && { echo "clang-tidy: left out"; exit 0; }
[ "$limit" = all ] && limit=1000000

passed=build/tidy-passed
mkdir -p "$passed"
shared_hash=$({ cat .clang-tidy; clang-tidy --version; find "${folders[@]}" -name '*.hpp' -print0 | sort -z | xargs -0 cat; } |
  sha256sum | cut -c1-32)

# What was changed last comes first, then what reads other people's bytes, should the time not be enough for all.
mapfile -t candidates < <(
  {
    git log --format= --name-only -n 300 2>/dev/null | grep '\.cpp$' || true
    for folder in base capture_format recorder server scenes/import replay process cli scenes/builder scenes/generate; do
      find "$folder" -name '*.cpp' | sort
    done
  } | awk '!seen[$0]++' | while read -r file; do
    [ -e "$file" ] || continue
    # Only what the build compiles has a command line to check it with.
    grep -qF "\"file\": \"$PWD/$file\"" build/release/compile_commands.json && echo "$file"
  done)

check_one() {
  local file=$1 key
  key=$(cat "$file" <(echo "$shared_hash") | sha256sum | cut -c1-32)
  [ -e "$passed/$key" ] && return 0
  if [ "$(date +%s)" -ge "$deadline" ]; then echo "$file" >>"$unreached"; return 0; fi
  if clang-tidy --quiet -p build/release "$file" >"$log_folder/${file//\//_}" 2>/dev/null; then
    : >"$passed/$key"
  else
    cat "$log_folder/${file//\//_}"
    return 255  # xargs then starts no more
  fi
}
export -f check_one
log_folder=$(mktemp -d)
trap 'rm -rf "$log_folder"' EXIT
unreached=$log_folder/unreached
: >"$unreached"
deadline=$(($(date +%s) + limit))
export passed shared_hash deadline unreached log_folder
echo "clang-tidy: ${#candidates[@]} files"
printf '%s\n' "${candidates[@]}" >"$log_folder/candidates"
xargs -a "$log_folder/candidates" -P "$(nproc)" -n 1 bash -c 'check_one "$1"' check_one
echo "clang-tidy: $(wc -l <"$unreached") of ${#candidates[@]} files not reached in time"

#!/usr/bin/env bash
# Installs the Debian packages that building, running and (with --tests) testing need; takes no time when they are there.
#   SUBPIXEL_MESA=backports   Debian 12: Mesa from the backports suite (the default; stock when it cannot be reached)
#   SUBPIXEL_MESA=stock       Debian 12: keep, or go back to, the Mesa of the release
set -euo pipefail
cd "$(dirname "$0")/.."

backports_entry=/etc/apt/sources.list.d/subpixel-backports.sources
backports_suite=bookworm-backports
unreachable_note=build/mesa-backports-unreachable

packages=(build-essential g++ cmake ninja-build pkg-config glslang-tools libvulkan-dev libcpp-httplib-dev
  nlohmann-json3-dev libopenimageio-dev libsqlite3-dev libassimp-dev libdraco-dev libmeshoptimizer-dev libzstd-dev libxxhash-dev libspdlog-dev libfmt-dev
  libcli11-dev libglm-dev libminizip-dev libgtest-dev libbenchmark-dev sweethome3d-furniture)
# Least versions, Debian 12's: older ones are known not to do (CMake's presets; a Vulkan extension's header; C++20).
least_versions=(cmake 3.25 libvulkan-dev 1.3.239 g++ 4:12)
test_packages=(clang-format clang-tidy nginx-light vulkan-validationlayers)

say() { printf 'packages: %s\n' "$*"; }
fail() { printf 'subpixel: packages: %s\n' "$*" >&2; exit 1; }

# Empty when it is not installed.
installed_version() { { dpkg-query -W -f='${db:Status-Abbrev}${Version}' "$1" 2>/dev/null || true; } | sed -n 's/^ii *//p'; }

as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"
  elif command -v sudo >/dev/null; then sudo "$@"
  else fail "neither root nor sudo; as root run: $*"; fi
}

# Waits for another apt that holds the lock, asks nothing, installs nothing that is only recommended.
apt_install() {
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
    -o DPkg::Lock::Timeout=300 -o Dpkg::Use-Pty=0 "$@"
}

lists_are_fresh=no
refresh_lists() {
  [ "$lists_are_fresh" = yes ] && return
  as_root apt-get update -q -o DPkg::Lock::Timeout=300
  lists_are_fresh=yes
}

# The URI and the keys of the machine's own entry for a suite, as the lines of a new entry. Reads both of apt's formats.
own_entry_for() {
  local files=()
  shopt -s nullglob
  files=(/etc/apt/sources.list.d/*.sources)
  if [ ${#files[@]} -gt 0 ]; then
    awk -v suite="$1" '
      function has(list, word) { return (" " list " ") ~ (" " word " ") }
      BEGIN { RS = ""; FS = "\n" }
      found { next }
      {
        delete value; name = ""
        for (i = 1; i <= NF; i++) {
          if ($i ~ /^#/) continue
          if ($i ~ /^[ \t]/) { value[name] = value[name] "\n" $i; continue }
          at = index($i, ":"); name = tolower(substr($i, 1, at - 1))
          text = substr($i, at + 1); sub(/^[ \t]+/, "", text); sub(/[ \t]+$/, "", text); value[name] = text
        }
        if (tolower(value["enabled"]) ~ /^(no|false|0)$/) next
        if (!has(value["types"], "deb") || !has(value["suites"], suite) || !has(value["components"], "main")) next
        split(value["uris"], uri, /[ \t\n]+/)
        print "URIs: " uri[1]
        if (value["signed-by"] != "") print "Signed-By: " value["signed-by"]
        if (value["trusted"] != "") print "Trusted: " value["trusted"]
        found = 1
      }
      END { exit !found }' "${files[@]}" && return 0
  fi
  files=(/etc/apt/sources.list /etc/apt/sources.list.d/*.list)
  cat "${files[@]}" 2>/dev/null | awk -v suite="$1" '
    found || $1 != "deb" { next }
    {
      options = ""; first = 2
      if ($2 ~ /^\[/) {
        while (first <= NF) { options = options " " $first; if ($(first++) ~ /\]$/) break }
        gsub(/[][]/, " ", options)
      }
      if ($(first + 1) != suite) next
      main = 0
      for (i = first + 2; i <= NF; i++) if ($i == "main") main = 1
      if (!main) next
      print "URIs: " $first
      count = split(options, option, /[ \t]+/)
      for (i = 1; i <= count; i++) {
        if (option[i] ~ /^signed-by=/) { sub(/^signed-by=/, "", option[i]); print "Signed-By: " option[i] }
        if (option[i] ~ /^trusted=/) { sub(/^trusted=/, "", option[i]); print "Trusted: " option[i] }
      }
      found = 1
    }
    END { exit !found }'
}

# Says at once all that the machine's package sources lack, where apt would name the first.
require_offered() {
  local package candidate absent=() old=() i
  for package in "$@"; do
    candidate=$(apt-cache policy "$package" 2>/dev/null | sed -n 's/^ *Candidate: *//p')
    if [ -z "$candidate" ] || [ "$candidate" = "(none)" ]; then absent+=("$package"); continue; fi
    for ((i = 0; i < ${#least_versions[@]}; i += 2)); do
      [ "${least_versions[i]}" != "$package" ] || dpkg --compare-versions "$candidate" ge "${least_versions[i + 1]}" ||
        old+=("$package $candidate (${least_versions[i + 1]} is needed)")
    done
  done
  local release; release=$(. /etc/os-release && echo "${PRETTY_NAME:-this system}")
  if [ ${#old[@]} -gt 0 ]; then fail "too old in $release: $(printf '%s; ' "${old[@]}")see docs/operations.md"; fi
  if [ ${#absent[@]} -gt 0 ]; then
    fail "the package sources of $release do not offer: ${absent[*]} (Ubuntu has them in universe: add-apt-repository universe)"
  fi
}

mesa_from_backports_is_offered() { apt-cache madison mesa-vulkan-drivers 2>/dev/null | grep -q '~bpo12'; }

# Adds the backports suite by the machine's own mirror. Its priority stays apt's 100 for backports: nothing comes from
# it but what is asked for by name. Leaves no entry behind when the mirror does not have it.
add_backports() {
  mesa_from_backports_is_offered && return 0
  local entry
  if [ ! -e "$backports_entry" ]; then
    entry=$(own_entry_for bookworm) || { say "no entry for Debian 12 found in /etc/apt"; return 1; }
    { printf '# Mesa for Subpixel; remove with: SUBPIXEL_MESA=stock scripts/install.sh\n'
      printf 'Types: deb\n%s\nSuites: %s\nComponents: main\n' "$entry" "$backports_suite"
    } | as_root tee "$backports_entry" >/dev/null
    say "added $backports_entry"
  fi
  as_root apt-get update -q -o DPkg::Lock::Timeout=300 -o APT::Update::Error-Mode=any \
    -o Dir::Etc::sourcelist="$backports_entry" -o Dir::Etc::sourceparts=- -o APT::Get::List-Cleanup=0 || true
  mesa_from_backports_is_offered && return 0
  as_root rm -f "$backports_entry"
  return 1
}

# Back to the release's Mesa: every package of Mesa's that came from backports goes to the release's version, or, when
# the release has none of that name, goes away.
restore_stock_mesa() {
  if [ -e "$backports_entry" ]; then as_root rm -f "$backports_entry"; say "removed $backports_entry"; fi
  refresh_lists
  local wanted=() package stock
  while read -r package; do
    stock=$(apt-cache madison "$package" | awk '$3 !~ /~bpo12/ { print $3; exit }')
    if [ -n "$stock" ]; then wanted+=("$package=$stock"); else wanted+=("$package-"); fi
  done < <(dpkg-query -W -f='${db:Status-Abbrev} ${source:Package} ${binary:Package} ${Version}\n' |
    awk '$1 == "ii" && $2 == "mesa" && $4 ~ /~bpo12/ { print $3 }')
  say "back to the release's Mesa: ${wanted[*]}"
  apt_install --allow-downgrades "${wanted[@]}"
}

settle_mesa() {
  local installed; installed=$(installed_version mesa-vulkan-drivers)
  . /etc/os-release
  if [ "${ID:-}" != debian ] || [ "${VERSION_ID:-}" != 12 ]; then
    packages+=(mesa-vulkan-drivers)
    return
  fi
  case "${SUBPIXEL_MESA:-backports}" in
    stock)
      if [[ "$installed" == *~bpo12* ]]; then restore_stock_mesa; else packages+=(mesa-vulkan-drivers); fi ;;
    backports)
      if [[ "$installed" == *~bpo12* ]]; then return; fi
      # One failed attempt is enough, unless backports are asked for by name.
      if [ -n "$installed" ] && [ -z "${SUBPIXEL_MESA:-}" ] && [ -e "$unreachable_note" ]; then return; fi
      say "Mesa: looking for the backports suite"
      # By name/suite, which takes from backports what Mesa needs and nothing more. With -t every dependency that is
      # newer there would come along, and the release's packages that want their own versions could not be installed.
      if add_backports && apt_install --no-remove "mesa-vulkan-drivers/$backports_suite"; then
        rm -f "$unreachable_note"
      else
        say "Mesa: backports cannot be reached; going on with the release's"
        mkdir -p build && touch "$unreachable_note"
        packages+=(mesa-vulkan-drivers)
      fi ;;
    *) fail "SUBPIXEL_MESA=$SUBPIXEL_MESA is neither backports nor stock" ;;
  esac
}

command -v dpkg-query >/dev/null && command -v apt-get >/dev/null ||
  fail "this is neither Debian nor Ubuntu; install what corresponds to: ${packages[*]} mesa-vulkan-drivers"

if [ "${1:-}" = --tests ]; then
  packages+=("${test_packages[@]}")
  # Node may come from elsewhere than the distribution, with its own npm.
  command -v node >/dev/null || packages+=(nodejs)
  command -v npm >/dev/null || packages+=(npm)
  # Ubuntu's chromium package only fetches a snap; a browser that is there already will do.
  . /etc/os-release
  if [ -z "${SUBPIXEL_CHROMIUM:-}" ] && ! command -v chromium >/dev/null && ! command -v google-chrome >/dev/null; then
    if [ "${ID:-}" = ubuntu ]; then say "no browser found: the browser tests will be skipped"; else packages+=(chromium); fi
  fi
fi

settle_mesa
missing=()
for package in "${packages[@]}"; do [ -n "$(installed_version "$package")" ] || missing+=("$package"); done
if [ ${#missing[@]} -gt 0 ]; then
  say "installing ${missing[*]}"
  refresh_lists
  require_offered "${missing[@]}"
  apt_install "${missing[@]}"
fi
say "all there; Mesa $(installed_version mesa-vulkan-drivers)"

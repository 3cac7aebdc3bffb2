#!/usr/bin/env bash
# Installs the Debian packages that building, running and (with --tests) testing need; takes no time when they are there.
#   SUBPIXEL_MESA=backports   Debian 12: Mesa from the backports suite (the default; stock when it cannot be reached)
#   SUBPIXEL_MESA=stock       Debian 12: keep, or go back to, the Mesa of the release
set -euo pipefail
cd "$(dirname "$0")/.."

. scripts/packages.sh
. scripts/mesa.sh

packages=(build-essential g++ cmake ninja-build pkg-config glslang-tools libvulkan-dev libcpp-httplib-dev
  nlohmann-json3-dev libopenimageio-dev libsqlite3-dev libassimp-dev libdraco-dev libmeshoptimizer-dev libzstd-dev libxxhash-dev libssl-dev zlib1g-dev libspdlog-dev libfmt-dev
  libcli11-dev libglm-dev libminizip-dev libseccomp-dev libgtest-dev libbenchmark-dev sweethome3d-furniture)
# Least versions, Debian 12's: older ones are known not to do (CMake's presets; a Vulkan extension's header; C++20).
least_versions=(cmake 3.25 libvulkan-dev 1.3.239 g++ 4:12)
test_packages=(clang-format clang-tidy nginx-light python3-yaml vulkan-validationlayers libembree-dev
  python3-renderdoc python3-numpy xvfb xauth libgl-dev libx11-dev libgl1-mesa-dri libegl1 vulkan-tools)

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

# Daemons for tests that start their own; machines that are without skip those tests. mariadb-server-core is the program
# alone, without a service.
idle_slurm=(munge slurm-client slurmctld slurmd)
idle_accounting=(slurmdbd mariadb-server-core)

# install_idle WHAT PACKAGE...: all of them, or none where the machine has some of its own.
install_idle() {
  local what=$1 package missing=(); shift
  for package in "$@"; do [ -n "$(installed_version "$package")" ] || missing+=("$package"); done
  if [ ${#missing[@]} = $# ]; then
    say "installing ${missing[*]}, not to be started"
    refresh_lists
    apt_install_idle "${missing[@]}" || say "no $what: its tests will be skipped"
  elif [ ${#missing[@]} -gt 0 ]; then
    say "this machine has a part of $what; not adding ${missing[*]}: its tests may be skipped"
  fi
}

settle_mesa
missing=()
for package in "${packages[@]}"; do [ -n "$(installed_version "$package")" ] || missing+=("$package"); done
if [ ${#missing[@]} -gt 0 ]; then
  say "installing ${missing[*]}"
  refresh_lists
  require_offered "${missing[@]}"
  apt_install "${missing[@]}"
fi
if [ "${1:-}" = --tests ]; then
  install_idle Slurm "${idle_slurm[@]}"
  install_idle "Slurm's accounting" "${idle_accounting[@]}"
fi
say "all there; Mesa $(installed_version mesa-vulkan-drivers)"

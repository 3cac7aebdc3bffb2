# Functions of install.sh that ask about Debian packages and install them; sourced.
# No pipe ends in a command that stops reading early (grep -q, head, awk's exit): the writer would die of SIGPIPE, and
# under pipefail that looks like a failure, now and then.

say() { printf 'packages: %s\n' "$*"; }
fail() { printf 'subpixel: packages: %s\n' "$*" >&2; exit 1; }

# Empty when it is not installed.
installed_version() { { dpkg-query -W -f='${db:Status-Abbrev}${Version}' "$1" 2>/dev/null || true; } | sed -n 's/^ii *//p'; }

as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"
  elif command -v sudo >/dev/null; then sudo "$@"
  else fail "neither root nor sudo; as root run: $*"; fi
}

can_be_root() { [ "$(id -u)" = 0 ] || command -v sudo >/dev/null; }

# Waits for another apt that holds the lock, asks nothing, installs nothing that is only recommended.
apt_install() {
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
    -o DPkg::Lock::Timeout=300 -o Dpkg::Use-Pty=0 "$@"
}

# Installs packages of daemons that nobody here wants to run: none is started, now or at the next start of the machine.
# Debian asks policy-rc.d before it starts a service; what the packages enable is disabled again.
policy=/usr/sbin/policy-rc.d
enabled_units=/etc/systemd/system/multi-user.target.wants
apt_install_idle() {
  local made=no unit
  if [ -e "$policy" ]; then
    "$policy" munge start >/dev/null 2>&1 && { say "$policy lets daemons start: not installing $*"; return; }
  else
    printf '#!/bin/sh\nexit 101\n' | as_root tee "$policy" >/dev/null
    as_root chmod 755 "$policy"
    made=yes
  fi
  apt_install "$@" || { [ $made = no ] || as_root rm -f "$policy"; return 1; }
  [ $made = no ] || as_root rm -f "$policy"
  for unit in munge slurmctld slurmd slurmdbd; do
    # `systemctl disable` does the same, where it is installed.
    as_root rm -f "$enabled_units/$unit.service"
  done
}

lists_are_fresh=no
refresh_lists() {
  [ "$lists_are_fresh" = yes ] && return
  as_root apt-get update -q -o DPkg::Lock::Timeout=300
  lists_are_fresh=yes
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

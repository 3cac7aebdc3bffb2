#!/usr/bin/env bash
# What scripts/install.sh decides about Mesa, with apt's programs replaced by fakes: nothing is installed.
#   tests/scripts/install_test.sh     exit code 1 when a case failed
set -euo pipefail
cd "$(dirname "$0")/../.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failures=0

# The fakes read and write what a case puts into $folder/state: `offered` (versions that apt-cache shows once the
# backports entry is there), `installed` (Mesa's version); apt-get's calls go to `calls`.
mkdir -p "$folder/bin" "$folder/state"
export FAKE=$folder/state FAKE_APT=$folder/apt
fake() { cat >"$folder/bin/$1"; chmod +x "$folder/bin/$1"; }
fake id <<'F'
#!/bin/sh
echo "$(cat "$FAKE/user")"
F
# More lines than a pipe holds, the one that matters first: who stops reading there ends the writer by SIGPIPE.
fake apt-cache <<'F'
#!/bin/bash
if [ -e "$FAKE/offered" ] && [ -e "$FAKE_APT/sources.list.d/subpixel-backports.sources" ]; then
  echo "mesa-vulkan-drivers | $(cat "$FAKE/offered") | http://mirror bookworm-backports/main amd64 Packages"
fi
for ((i = 0; i < 1500; ++i)); do
  echo "mesa-vulkan-drivers | 22.3.6-1+deb12u1 | http://mirror.of.a.long.name/debian bookworm/main amd64 Packages"
done
F
fake apt-get <<'F'
#!/bin/sh
echo "$*" | sed 's/.*install -y.*Use-Pty=0/install/' >>"$FAKE/calls"
if [ -n "$FAKE_POLICY" ] && [ -e "$FAKE_POLICY" ]; then "$FAKE_POLICY"; echo "policy: $?" >>"$FAKE/calls"; fi
case "$*" in
  *install*mesa-vulkan-drivers/bookworm-backports*)
    if [ -e "$FAKE/conflict" ]; then exit 100; fi
    cat "$FAKE/offered" >"$FAKE/installed" ;;
esac
F
fake dpkg-query <<'F'
#!/bin/sh
if [ -s "$FAKE/installed" ]; then echo "ii $(cat "$FAKE/installed")"; else exit 1; fi
F
export PATH=$folder/bin:$PATH

. scripts/packages.sh
. scripts/mesa.sh
apt_folder=$folder/apt
unreachable_note=$folder/build/note
is_debian_12() { true; }

# A machine as it comes: the mirror's entry, no backports, the Mesa `$1` (empty: none), no note.
machine() {
  rm -rf "$folder/build" "$FAKE_APT" "$FAKE"
  mkdir -p "$FAKE_APT/sources.list.d" "$FAKE"
  printf 'Types: deb\nURIs: http://mirror/debian\nSuites: bookworm bookworm-updates\nComponents: main\n' \
    >"$FAKE_APT/sources.list.d/debian.sources"
  printf '%s' "$1" >"$FAKE/installed"
  echo 0 >"$FAKE/user"
  : >"$FAKE/calls"
  packages=()
}
settle() { (packages=(); settle_mesa; echo "left to install: ${packages[*]}") >"$folder/said" 2>&1 || echo "ended with $?" >>"$folder/said"; }
# expect WHAT COMMAND...: COMMAND succeeds.
expect() {
  local what=$1
  shift
  if "$@"; then return; fi
  failures=$((failures + 1))
  printf 'FAILED: %s\n' "$what"
  sed 's/^/  /' "$folder/said"
}
said() { grep -qF -- "$1" "$folder/said"; }
silent() { ! grep -q . "$FAKE/calls"; }
has_mesa() { [ "$(cat "$FAKE/installed")" = "$1" ]; }

stock=22.3.6-1+deb12u1
backports=25.0.7-2~bpo12+1
: >"$folder/said"

machine $stock
echo $backports >"$FAKE/offered"
touch "$FAKE_APT/sources.list.d/subpixel-backports.sources"
missed=0 missed_with_grep=0
for ((i = 0; i < 200; ++i)); do mesa_from_backports_is_offered || missed=$((missed + 1)); done
expect "what apt-cache shows is seen every time (missed $missed of 200)" [ $missed = 0 ]
for ((i = 0; i < 20; ++i)); do
  apt-cache madison mesa-vulkan-drivers | grep -q '~bpo12' || missed_with_grep=$((missed_with_grep + 1))
done
expect "this test's apt-cache is one that a pipe to grep -q fails with" [ $missed_with_grep -gt 0 ]
rm "$FAKE/offered"
expect "what is not shown is not seen" eval '! mesa_from_backports_is_offered'

machine ""
echo $backports >"$FAKE/offered"
settle
expect "a fresh machine gets Mesa from backports" has_mesa $backports
expect "and no note" [ ! -e "$unreachable_note" ]
expect "the entry has the mirror's address" grep -q '^URIs: http://mirror/debian' "$FAKE_APT/sources.list.d/subpixel-backports.sources"

machine ""
rm "$FAKE_APT/sources.list.d/debian.sources"
echo 'deb [signed-by=/keys/debian.gpg] http://listed/debian bookworm main' >"$FAKE_APT/sources.list.d/own.list"
echo $backports >"$FAKE/offered"
settle
expect "a mirror in a .list file does, without a sources.list" has_mesa $backports
expect "its keys come along" grep -q '^Signed-By: /keys/debian.gpg' "$FAKE_APT/sources.list.d/subpixel-backports.sources"

machine $stock
mkdir -p "$folder/build"
touch "$unreachable_note"
echo $backports >"$FAKE/offered"
settle
expect "a machine with an earlier version's note gets out of it by itself" has_mesa $backports
expect "and loses the note" [ ! -e "$unreachable_note" ]

machine $stock
settle
expect "without backports the release's Mesa stays" said "left to install: mesa-vulkan-drivers"
expect "the reason is said" said "backports cannot be reached"
expect "no entry stays behind" [ ! -e "$FAKE_APT/sources.list.d/subpixel-backports.sources" ]
: >"$FAKE/calls"
settle
expect "the mirror is not asked again the same day" silent
touch -d '2 days ago' "$unreachable_note"
echo $backports >"$FAKE/offered"
settle
expect "but the day after" has_mesa $backports

machine $stock
echo $backports >"$FAKE/offered"
touch "$FAKE/conflict"
settle
expect "a package that would have to go keeps the release's Mesa" said "cannot be installed without removing"
expect "which is left to be installed" said "left to install: mesa-vulkan-drivers"

machine $stock
echo 1000 >"$FAKE/user"
echo $backports >"$FAKE/offered"
if ! command -v sudo >/dev/null; then
  settle
  expect "a user without rights goes on with what is installed" eval 'silent && said "left to install: "'
fi

machine $backports
settle
expect "Mesa from backports stays, and nobody is asked" silent

# Daemons that tests start themselves are not started by their packages.
export FAKE_POLICY=$folder/policy-rc.d
policy=$FAKE_POLICY
enabled_units=$folder/wants
mkdir "$enabled_units"
touch "$enabled_units/slurmd.service" "$enabled_units/cron.service"
machine $stock
(apt_install_idle munge slurmd) >"$folder/said" 2>&1
expect "they are installed while nothing may be started" grep -q "^install .*munge slurmd$" "$FAKE/calls"
expect "which the packages were told" grep -q "^policy: 101" "$FAKE/calls"
expect "none is started with the machine either" [ "$(ls "$enabled_units")" = cron.service ]
expect "and the machine is not told any longer" [ ! -e "$FAKE_POLICY" ]
machine $stock
printf '#!/bin/sh\nexit 0\n' >"$FAKE_POLICY"
chmod +x "$FAKE_POLICY"
(apt_install_idle munge slurmd) >"$folder/said" 2>&1
expect "a machine that lets daemons start gets none" eval 'silent && said "not installing munge slurmd"'
expect "and keeps its policy" [ -e "$FAKE_POLICY" ]
rm "$FAKE_POLICY"

# `writer | reader` where the reader may stop early ends the writer by SIGPIPE, which pipefail makes a failure.
mapfile -t scripts < <(git ls-files '*.sh' .ci/run 2>/dev/null || find . -name '*.sh' -not -path './build/*')
early_end='\|[^|]*(grep +-[a-zA-Z]*[qm]|\bhead\b|\bsed +(-[nEr]+ +)?.?[0-9]*q|awk .*\bexit *}.*[^"]$)'
for script in "${scripts[@]}"; do
  if [ "$script" = tests/scripts/install_test.sh ]; then continue; fi
  expect "$script has no pipe to a command that stops reading early" eval '! grep -nE "^[^#]*$early_end" "$script"'
done

[ $failures = 0 ] && echo "all cases passed"
[ $failures = 0 ]

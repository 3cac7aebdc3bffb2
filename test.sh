#!/usr/bin/env bash
# Installs what the tests need, builds, checks the sources' form and runs every test.
#   SUBPIXEL_TIDY_SECONDS=N   time for clang-tidy (default 0: left out; "all" checks every file)
set -euo pipefail
cd "$(dirname "$0")"

step() { printf '\n== %s\n' "$*"; }

step "1/4 packages"
scripts/install.sh --tests
# The browser tests' driver, as its lock file has it; npm leaves a copy of the lock file when it is through.
browser=tests/browser
if [ -e $browser/package-lock.json ] && ! [ $browser/node_modules/.package-lock.json -nt $browser/package-lock.json ]; then
  (cd $browser && PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD=1 npm ci --no-audit --no-fund)
  touch $browser/node_modules/.package-lock.json
fi

step "2/4 build"
[ -e build/release/build.ninja ] || cmake --preset release
cmake --build --preset release

step "3/4 form of the sources"
SUBPIXEL_TIDY_SECONDS=${SUBPIXEL_TIDY_SECONDS:-0} scripts/check_sources.sh

step "4/4 tests"
ctest --preset release -j2

#!/usr/bin/env bash
# Installs the recorder and builds the examples as somebody else's project does: by find_package, in C and in C++, shared
# and static. What they record is a capture of 100 frames, the same by each. Argument: the build's folder.
set -euo pipefail
source_dir=$(cd "$(dirname "$0")/../.." && pwd)
build=$1
work=$build/tests/package_work
subpixel=$build/subpixel
fail() { echo "FAILED: $*" >&2; exit 1; }
rm -rf "$work"
mkdir -p "$work"
cmake --install "$build" --component recorder --prefix "$work/installed" >"$work/install.log"
# Where it was installed first is not where it has to stay.
mv "$work/installed" "$work/prefix"
prefix=$work/prefix

configure() {  # FOLDER OPTION...
  cmake -S "$source_dir/tests/package" -B "$work/$1" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_BUILD_TYPE=Release \
    -DEXAMPLES="$source_dir/recorder/examples" "${@:2}" >"$work/$1.log" 2>&1 || { cat "$work/$1.log"; fail "configuring $1"; }
  cmake --build "$work/$1" >>"$work/$1.log" 2>&1 || { cat "$work/$1.log"; fail "building $1"; }
}
configure build
configure c_alone -DWITH_CPP=OFF

for program in build/c_shared build/c_static build/cpp_shared build/cpp_static c_alone/c_shared; do
  capture=$work/${program//\//_}.spcap
  "$work/$program" "$capture"
  "$subpixel" validate "$capture" >"$work/validated" || { cat "$work/validated"; fail "$program: not valid"; }
  "$subpixel" info "$capture" --json >"$work/info.json"
  python3 - "$work/info.json" <<'CHECK' || fail "$program: info says otherwise"
import json, sys
info = json.load(open(sys.argv[1]))
assert len(info["frames"]) == 100, len(info["frames"])
assert all(frame["triangles"] == 6 for frame in info["frames"])
CHECK
  # Nothing that was linked in needs more than zstd, xxHash and the languages.
  needed=$(readelf -d "$work/$program" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' |
    grep -vE '^(libsubpixel_recorder|libzstd|libxxhash|libstdc\+\+|libgcc_s|libm|libc|libpthread|ld-linux[a-z0-9-]*)\.so' || true)
  [ -z "$needed" ] || fail "$program needs $needed"
done
# A failure is told, not thrown.
message=$("$work/build/c_shared" "$work/absent/x.spcap" 2>&1) && fail "recording into no folder succeeded"
[[ $message == *absent* ]] || fail "the error does not name the path: $message"

library=$(echo "$prefix"/lib*/libsubpixel_recorder.so)
[ -e "$library" ] || library=$(find "$prefix" -name libsubpixel_recorder.so)
needed=$(readelf -d "$library" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' |
  grep -vE '^(libzstd|libxxhash|libstdc\+\+|libgcc_s|libm|libc|libpthread|ld-linux[a-z0-9-]*)\.so' || true)
[ -z "$needed" ] || fail "the library needs $needed"
readelf -d "$library" | grep 'SONAME.*libsubpixel_recorder\.so\.[0-9]' >/dev/null || fail "no SONAME with a number"
# Every function of the header is there, and what is there is C's functions and the C++ recorders alone.
nm -D --defined-only "$library" | awk '{print $3}' | sed 's/@.*//' | sort >"$work/shown"
grep -oE 'subpixel_[a-z_]+\(' "$source_dir/recorder/subpixel_recorder.h" | tr -d '(' | sort -u |
  comm -23 - "$work/shown" >"$work/hidden"
[ ! -s "$work/hidden" ] || fail "not shown: $(tr '\n' ' ' <"$work/hidden")"
others=$(c++filt <"$work/shown" | grep -vE '^(subpixel_|SUBPIXEL_RECORDER_1|subpixel::capture::(Stream)?Recorder::|(vtable|typeinfo|typeinfo name) for subpixel::)' || true)
[ -z "$others" ] || fail "shown: $others"
# No path of the machine that built it.
! grep -rqF "$source_dir" "$prefix/lib"*/cmake "$prefix/include" || fail "what is installed names the sources' folder"
echo "package: 5 programs recorded 100 frames each"

#!/usr/bin/env bash
# Whether the build knows for every shader what it includes: no less, or an edit is not seen, and no more, or one edit
# compiles them all. Compares what the last build recorded beside each file with the includes the sources have.
#   shader_dependencies_test.sh FOLDER_OF_SPIRV
set -euo pipefail
spirv=$1
shaders=$(cd "$(dirname "$0")/../../shaders" && pwd)
fail() { echo "shader dependencies: $*" >&2; exit 1; }

# Shaders name files from the root of shaders/, headers that the host includes too from where they are.
declare -A includes_of
while IFS= read -r file; do
  names=""
  while IFS= read -r name; do
    [ -e "$shaders/$name" ] || name=$(realpath -m --relative-to="$shaders" "$shaders/$(dirname "$file")/$name")
    names+="$name"$'\n'
  done < <(sed -n 's/^ *# *include "\(.*\)".*/\1/p' "$shaders/$file")
  includes_of[$file]=$names
done < <(cd "$shaders" && find . -type f | sed 's|^\./||')

# The files of ours that a shader can reach, itself among them.
reachable() {
  local queue=("$1") file
  local -A seen=()
  while [ ${#queue[@]} -gt 0 ]; do
    file=${queue[0]} queue=("${queue[@]:1}")
    if [ -n "${seen[$file]:-}" ] || [ -z "${includes_of[$file]+known}" ]; then continue; fi
    seen[$file]=1
    queue+=(${includes_of[$file]})
  done
  printf '%s\n' "${!seen[@]}"
}

checked=0
while read -r file; do
  shader=${file#"$spirv/"} shader=${shader%.spv}
  [ -e "$shaders/$shader" ] || shader=${shader%.*}  # its variant
  [ -e "$shaders/$shader" ] || continue             # of a shader that is no more
  recorded=$(tr ' ' '\n' <"$file.d" | grep -F "$shaders/" | xargs realpath -m --relative-to="$shaders" | sort -u)
  grep -qxF "$shader" <<<"$recorded" || fail "$file: its own source is not recorded"
  reached=$(reachable "$shader" | sort)
  extra=$(comm -23 <(echo "$recorded") <(echo "$reached") | tr '\n' ' ')
  [ -z "$extra" ] || fail "$file: depends on $extra which it can't include"
  # Includes within #if may be left out of a variant; those at the top of the shader that has none may not.
  if ! grep -q '^ *# *if' "$shaders/$shader"; then
    for include in ${includes_of[$shader]}; do
      [ -z "${includes_of[$include]+known}" ] || grep -xF "$include" <<<"$recorded" >/dev/null || fail "$file: does not depend on $include"
    done
  fi
  checked=$((checked + 1))
done < <(find "$spirv" -name '*.spv' | sort)
[ "$checked" -gt 100 ] || fail "$checked shaders in $spirv"
echo "shader dependencies: $checked shaders"

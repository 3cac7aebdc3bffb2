# Functions of install.sh that choose between the Mesa of Debian 12 and that of its backports suite; sourced after
# packages.sh, whose remark on pipes holds here too.

apt_folder=/etc/apt
backports_suite=bookworm-backports
unreachable_note=build/mesa-backports-unreachable

# The URI and the keys of the machine's own entry for a suite, as the lines of a new entry. Reads both of apt's formats.
own_entry_for() {
  local files=()
  shopt -s nullglob
  files=("$apt_folder"/sources.list.d/*.sources)
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
  files=("$apt_folder"/sources.list.d/*.list)
  if [ -e "$apt_folder"/sources.list ]; then files=("$apt_folder"/sources.list "${files[@]}"); fi
  [ ${#files[@]} -gt 0 ] || return 1
  awk -v suite="$1" '
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
    END { exit !found }' "${files[@]}"
}

mesa_from_backports_is_offered() { [[ "$(apt-cache madison mesa-vulkan-drivers 2>/dev/null)" == *~bpo12* ]]; }

# Adds the backports suite by the machine's own mirror. Its priority stays apt's 100 for backports: nothing comes from
# it but what is asked for by name. Leaves no entry behind when the mirror does not have it.
add_backports() {
  mesa_from_backports_is_offered && return 0
  local entry backports_entry=$apt_folder/sources.list.d/subpixel-backports.sources
  if [ ! -e "$backports_entry" ]; then
    entry=$(own_entry_for bookworm) || { say "no entry for Debian 12 found in $apt_folder"; return 1; }
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
  local backports_entry=$apt_folder/sources.list.d/subpixel-backports.sources
  if [ -e "$backports_entry" ]; then as_root rm -f "$backports_entry"; say "removed $backports_entry"; fi
  refresh_lists
  local wanted=() package stock
  while read -r package; do
    stock=$(apt-cache madison "$package" | awk '!found && $3 !~ /~bpo12/ { print $3; found = 1 }')
    if [ -n "$stock" ]; then wanted+=("$package=$stock"); else wanted+=("$package-"); fi
  done < <(dpkg-query -W -f='${db:Status-Abbrev} ${source:Package} ${binary:Package} ${Version}\n' |
    awk '$1 == "ii" && $2 == "mesa" && $4 ~ /~bpo12/ { print $3 }')
  say "back to the release's Mesa: ${wanted[*]}"
  apt_install --allow-downgrades "${wanted[@]}"
}

# Earlier versions left an empty note after a check that failed by chance; such a note says nothing. A mirror is asked
# again after a day.
backports_were_unreachable() { [ -n "$(find "$unreachable_note" -mmin -1440 -size +0 2>/dev/null)" ]; }

# Puts the release's Mesa among `packages`, for `reason`.
keep_stock_mesa() {
  local reason=$1
  say "Mesa: $reason; going on with the release's"
  mkdir -p "$(dirname "$unreachable_note")"
  printf '%s\n' "$reason" >"$unreachable_note"
  packages+=(mesa-vulkan-drivers)
}

is_debian_12() { . /etc/os-release && [ "${ID:-}" = debian ] && [ "${VERSION_ID:-}" = 12 ]; }

# Installs Mesa from backports, or leaves the package of the release to be installed with the others (`packages`).
settle_mesa() {
  local installed; installed=$(installed_version mesa-vulkan-drivers)
  if ! (is_debian_12); then
    packages+=(mesa-vulkan-drivers)
    return
  fi
  case "${SUBPIXEL_MESA:-backports}" in
    stock)
      if [[ "$installed" == *~bpo12* ]]; then restore_stock_mesa; else packages+=(mesa-vulkan-drivers); fi ;;
    backports)
      if [[ "$installed" == *~bpo12* ]]; then return; fi
      if [ -n "$installed" ] && [ -z "${SUBPIXEL_MESA:-}" ]; then
        # What runs already is not worth a password, nor a wait on every start.
        if backports_were_unreachable || ! can_be_root; then return; fi
      fi
      say "Mesa: looking for the backports suite"
      if ! add_backports; then
        keep_stock_mesa "backports cannot be reached"
      # By name/suite, which takes from backports what Mesa needs and nothing more. With -t every dependency that is
      # newer there would come along, and the release's packages that want their own versions could not be installed.
      elif apt_install --no-remove "mesa-vulkan-drivers/$backports_suite"; then
        rm -f "$unreachable_note"
      else
        keep_stock_mesa "the one of backports cannot be installed without removing other packages"
      fi ;;
    *) fail "SUBPIXEL_MESA=$SUBPIXEL_MESA is neither backports nor stock" ;;
  esac
}

# Installs what is missing and builds. Sourced by ./run and ./check; both run from the project's root.

say() { printf '==> %s s: %s\n' "$SECONDS" "$*"; }

# The package mirror, as this machine's own apt has it.
apt_mirror() { apt-get indextargets --format '$(SITE)' "Created-By: Packages" | head -n 1; }

# agreed QUESTION: whether a person at this terminal says yes. Nobody there, or no sudo: no.
agreed() {
  [ -t 0 ] && [ -t 2 ] && command -v sudo > /dev/null || return 1
  local answer
  read -r -p "==> $1 [y/N] " answer
  [[ $answer == [yY]* ]]
}

# size_of PACKAGE...: what apt would fetch and use for them and all that they need.
size_of() {
  local plan
  plan=$(LC_ALL=C apt-get install -o Debug::NoLocking=true --assume-no --no-install-recommends "$@" 2> /dev/null |
         sed -n 's/^Need to get \(.*\) of archives.*/\1 to fetch/p; s/^After this operation, \(.*\) of additional.*/\1 of disk/p' | paste -sd, | sed 's/,/, /')
  echo "${plan:-of unknown size before apt-get update}"
}

# install_missing [all]: the packages of scripts/packages.txt that this machine lacks; "all" adds the lines marked #all.
install_missing() {
  local wanted missing=() package
  wanted=$(sed -n 's/^\([a-z].*\)$/\1/p' scripts/packages.txt)
  [ "${1:-}" = all ] && wanted+=" $(sed -n 's/^#all //p' scripts/packages.txt)"
  for package in $wanted; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return 0
  local as_root=() log
  if [ "$(id -u)" -ne 0 ]; then
    as_root=(sudo)
    say "missing: ${missing[*]}"
    if ! agreed "install these ${#missing[@]} packages with sudo, $(size_of "${missing[@]}")?"; then
      say "install them with this line and start again:"
      echo "    sudo apt-get update && sudo apt-get install -y --no-install-recommends ${missing[*]}"
      exit 69
    fi
  fi
  say "installing ${#missing[@]} packages, $(size_of "${missing[@]}"): ${missing[*]}"
  log=$(mktemp)
  if ! { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update &&
         "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"; } > "$log" 2>&1; then
    tail -n 20 "$log" >&2
    say "apt-get failed; its output is in $log"
    exit 69
  fi
  rm -f "$log"
}

# build PRESET [TARGET...]: configures when needed; the second time only what changed is compiled.
build() {
  local preset=$1
  shift
  [ -f "build/$preset/build.ninja" ] || { say "configuring build/$preset"; cmake --preset "$preset" > "/tmp/stillpoint-configure-$$.log" 2>&1 ||
    { cat "/tmp/stillpoint-configure-$$.log" >&2; exit 1; }; rm -f "/tmp/stillpoint-configure-$$.log"; }
  say "building build/$preset"
  NINJA_STATUS='[%f/%t] ' cmake --build --preset "$preset" ${1:+--target "$@"}
}

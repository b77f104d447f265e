# Installs what is missing and builds. Sourced by ./run and ./check; both run from the project's root.

say() { printf '==> %s\n' "$*"; }

# install_missing [all]: the packages of scripts/packages.txt that this machine lacks; "all" adds the lines marked #all.
install_missing() {
  local wanted missing=() package
  wanted=$(sed -n 's/^\([a-z].*\)$/\1/p' scripts/packages.txt)
  [ "${1:-}" = all ] && wanted+=" $(sed -n 's/^#all //p' scripts/packages.txt)"
  for package in $wanted; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return 0
  if [ "$(id -u)" -ne 0 ]; then
    say "these packages are missing; install them with this line and start again:"
    echo "    sudo apt-get update && sudo apt-get install -y --no-install-recommends ${missing[*]}"
    exit 69
  fi
  say "installing ${#missing[@]} packages: ${missing[*]}"
  local log
  log=$(mktemp)
  if ! { DEBIAN_FRONTEND=noninteractive apt-get update &&
         DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"; } > "$log" 2>&1; then
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

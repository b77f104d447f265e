#!/usr/bin/env bash
# The Debian packages of a build: made, accepted by lintian, and what must be in them: packages.sh BUILD_FOLDER
set -euo pipefail
build=$1
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
(cd "$out" && cpack -G DEB --config "$build/CPackConfig.cmake" -B "$out" > "$out/log" 2>&1) || { cat "$out/log"; exit 1; }
ls -l "$out"/*.deb | awk '{ printf "%8d bytes  %s\n", $5, $NF }'
expect() { dpkg-deb -c "$out"/$1_*.deb > "$out/list"; grep -q "$2" "$out/list" || { echo "$1 lacks $2"; exit 1; }; }
expect stillpointd usr/bin/stillpointd
expect stillpointd lib/systemd/system/stillpointd.service
expect stillpointd sysusers.d/stillpointd.conf
expect stillpointd share/stillpoint/dds_keys.sh
expect stillpointd man1/stillpointd.1.gz
expect stillpoint bash-completion/completions/stillpoint
expect libstillpoint 'libstillpoint_c.so.1'
expect libstillpoint-dev include/stillpoint.h
expect libstillpoint-dev StillpointConfig.cmake
! ls "$out"/python3-stillpoint_*.deb > /dev/null 2>&1 || expect python3-stillpoint dist-packages/stillpoint/_native
expect stillpoint-doc daemon.md
dpkg-deb -f "$out"/stillpointd_*.deb Depends | grep -q libc6 || { echo "no dependencies were found"; exit 1; }
if command -v lintian > /dev/null; then
  lintian --fail-on error "$out"/*.deb
else
  echo "LOUD: lintian is not installed: its judgement is SKIPPED"
fi

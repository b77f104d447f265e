#!/usr/bin/env bash
# The Debian packages of a build in a clean Debian, as autopkgtest would have it: they install with nothing but what they
# depend on, the programs work, a purge leaves nothing. clean_install.sh BUILD_FOLDER
# Needs root, debootstrap and the network. CLEAN_DEBIAN names a tree that debootstrap --variant=minbase has already made.
set -euo pipefail
. "$(dirname "$0")/../../scripts/setup.sh"
build=$1
mirror=$(apt_mirror)
skip() { echo "LOUD: $1: whether the packages install in a clean Debian is SKIPPED"; exit 77; }
[ "$(id -u)" -eq 0 ] || skip "not root"
command -v debootstrap > /dev/null || skip "debootstrap is not installed"
unshare --mount true 2> /dev/null || skip "no mount namespaces here"
work=$(mktemp -d)
trap 'rm -rf --one-file-system "$work"' EXIT
timeout 60 /usr/lib/apt/apt-helper download-file "$mirror/dists/bookworm/Release" "$work/Release" > /dev/null 2>&1 ||
  skip "$mirror cannot be reached"
loudly() { "$@" > "$work/log" 2>&1 || { tail -n 30 "$work/log"; echo "failed: $*"; exit 1; }; }
tree=$work/debian
# What is mounted ends with the command.
inside() {
  unshare --mount sh -c 'mount -t proc proc "$0/proc" && exec chroot "$0" "$@"' "$tree" \
    env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/srv DEBIAN_FRONTEND=noninteractive "$@"
}

(cd "$work" && loudly cpack -G DEB --config "$build/CPackConfig.cmake" -B "$work")
if [ -n "${CLEAN_DEBIAN:-}" ]; then
  cp -a "$CLEAN_DEBIAN" "$tree"
else
  loudly debootstrap --variant=minbase bookworm "$tree" "$mirror"
fi
cp "$work"/*.deb "$tree/srv"
cp /etc/resolv.conf "$tree/etc/resolv.conf"
loudly inside apt-get update
loudly inside sh -c 'apt-get install -y --no-install-recommends /srv/*.deb'
inside dpkg --audit | tee "$work/audit"
[ ! -s "$work/audit" ] || { echo "a package is not whole"; exit 1; }

cat > "$tree/srv/sim.yaml" <<'END'
rate_hz: 100
accelerometer: {noise_mps2: 0.02}
gyroscope: {noise_radps: 0.001}
motion: {kind: hand, duration_s: 20}
END
cat > "$tree/srv/daemon.yaml" <<'END'
source: {kind: recording, file: rec.csv, speed: 0}
sensor: {id: clean}
END
inside sh -euc '
  cd /srv
  stillpoint check sim.yaml
  stillpoint simulate --simulation sim.yaml --output rec.csv
  stillpoint estimate --config daemon.yaml --recording rec.csv --output att.csv
  stillpointd --config daemon.yaml
  if dpkg -s python3-stillpoint > /dev/null 2>&1; then
    python3 -c "import stillpoint as sp; assert len(sp.estimate(\"rec.csv\")) == 2000, \"rows\""
  fi
  test -f /lib/systemd/system/stillpointd.service' || { echo "what was installed does not work"; exit 1; }

loudly inside apt-get purge -y '*stillpoint*'
left=$(inside sh -c 'dpkg-query -W -f "\${Package}\n" | grep stillpoint; find /usr /etc /lib -name "*stillpoint*"' || true)
[ -z "$left" ] || { echo "a purge leaves:"; echo "$left"; exit 1; }
echo "installed, worked and purged in a clean Debian"

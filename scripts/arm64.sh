#!/usr/bin/env bash
# Cross-compiles core, calib_online, fusion, laws, simulation, io (without DDS and the daemon's configuration), pipeline,
# c_api, report and diagnosis for 64-bit ARM and runs their tests, but for those labelled long, under qemu-user. In a chroot
# of its own, because Debian cannot hold libyaml-cpp-dev for two architectures at once. HEAD is what is built.
#   sudo scripts/arm64.sh FOLDER      FOLDER is made with debootstrap when it is absent (about 2 GB)
set -euo pipefail
[ $# -eq 1 ] || { echo "usage: sudo scripts/arm64.sh FOLDER" >&2; exit 64; }
[ "$(id -u)" -eq 0 ] || { echo "debootstrap and chroot need root" >&2; exit 64; }
cd "$(dirname "$0")/.."
. scripts/setup.sh
chroot_folder=$(realpath -m "$1")
mirror=$(apt_mirror)

[ -e "$chroot_folder/etc/debian_version" ] || debootstrap --variant=minbase bookworm "$chroot_folder" "$mirror"
mountpoint -q "$chroot_folder/proc" || mount -t proc proc "$chroot_folder/proc"
mountpoint -q "$chroot_folder/dev" || mount --bind /dev "$chroot_folder/dev"
trap 'umount "$chroot_folder/proc" "$chroot_folder/dev"' EXIT

mkdir -p "$chroot_folder/src"
git archive --prefix=stillpoint/ HEAD | tar -x -C "$chroot_folder/src"
chroot "$chroot_folder" bash -eu -c '
  export DEBIAN_FRONTEND=noninteractive
  dpkg --add-architecture arm64
  apt-get update -q
  apt-get install -y -q --no-install-recommends cmake ninja-build python3 g++-aarch64-linux-gnu qemu-user \
    libeigen3-dev nlohmann-json3-dev libexpected-dev libyaml-cpp-dev:arm64 libfmt-dev:arm64 libssl-dev:arm64 libgtest-dev:arm64 libgmock-dev:arm64
  cd /src/stillpoint
  cmake --preset arm64
  cmake --build --preset arm64
  ctest --preset arm64 -j "$(nproc)"
'

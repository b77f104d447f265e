#!/bin/busybox sh
# Process 1 of the guest: plays hub and daemon through the phases that kernel_guest.py judges. What they said lies in
# /out, and goes to the host as a tar on the disk. FIRST and AGAIN (readings of a sensor) come from the command line.
/bin/busybox mkdir -p /proc /sys /dev /tmp /out /sbin /usr/bin
/bin/busybox --install -s /bin
mount -t proc none /proc
mount -t sysfs none /sys
mount -t devtmpfs none /dev
mkdir -p /dev/shm
mount -t tmpfs none /dev/shm
ip link set lo up
for word in $(cat /proc/cmdline); do
  case $word in first=* | again=*) export "$word" ;; esac
done

say() { echo "guest: $(cut -d' ' -f1 /proc/uptime) s: $*"; }
end() {
  say "$1"
  echo "$1" > /out/end.txt
  dmesg > /out/dmesg.txt
  tar -C /out -cf /dev/vda .
  sync
  poweroff -f
}
seconds() { cut -d. -f1 /proc/uptime; }
# until_true WHAT SECONDS COMMAND...: waits for a success of COMMAND; the bound is there for a daemon that hangs.
until_true() {
  what=$1 until=$(($(seconds) + $2))
  shift 2
  while ! "$@" > /dev/null 2>&1; do
    [ "$(seconds)" -lt $until ] || end "GAVE UP waiting for: $what"
    sleep 0.2
  done
  say "$what"
}
devices() { [ "$(ls /sys/bus/iio/devices 2> /dev/null | grep -c iio:device)" = "$1" ]; }
count() { [ "$(grep -c "$1" "$2")" -ge "$3" ]; }
stale() { stillpoint status --json --timeout 20 > /tmp/status.json 2>> /out/status.log && grep -q '"status": "stale"' /tmp/status.json; }
fresh() { stillpoint status --json --timeout 20 > /tmp/status.json 2>> /out/status.log && ! grep -q '"status": "stale"' /tmp/status.json; }

for module in $(cat /modules/order); do insmod "/modules/$module" || end "cannot load $module"; done
mkfifo /tmp/commands
virtual_hub < /tmp/commands > /out/hub.log 2>&1 &
exec 3> /tmp/commands

echo "plug 0" >&3
until_true "the kernel has three devices" 300 devices 3
stillpoint devices --json --listen 0 > /out/devices.json 2> /out/devices.err
for device in /sys/bus/iio/devices/*; do
  for file in "$device"/name "$device"/in_* "$device"/scan_elements/*_type "$device"/trigger/current_trigger; do
    echo "$file $(cat "$file" 2>&1)"
  done
done > /out/sysfs.txt
echo "unplug" >&3
until_true "the devices are gone" 300 devices 0

stillpointd --config /config.yaml 2> /out/daemon.log &
daemon=$!
stillpoint record --output /out/raw.csv --timeout 600 > /out/record.log 2>&1 &
record=$!
until_true "the daemon is there and waits for its devices" 300 stale

echo "plug $first" >&3
until_true "a second of readings" 300 count . /out/raw.csv 600
until_true "its status says that samples come" 300 fresh
cp /tmp/status.json /out/running.json
until_true "each sensor sent $first readings" $((first / 20 + 300)) count "^sent .* $first\$" /out/hub.log 3
until_true "its status says STALE" 300 stale
cp /tmp/status.json /out/quiet.json

echo "unplug" >&3
until_true "the devices are gone" 300 devices 0
until_true "the daemon says that it has none" 300 count 'no motion sensor' /out/daemon.log 2
echo "plug $again" >&3
until_true "the daemon takes readings again by itself" 300 grep -q 'source: there again' /out/daemon.log
until_true "each sensor sent $again more" $((again / 20 + 300)) count "^sent .* $((first + again))\$" /out/hub.log 3
until_true "its status says STALE again" 300 stale
kill -INT $record
wait $record
echo "exit $?" >> /out/record.log
kill -TERM $daemon
wait $daemon
echo "exit $?" >> /out/daemon.log
end "DONE"

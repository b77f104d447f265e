#!/usr/bin/env bash
# The system calls of the daemon's sensor thread while samples run: `bench/syscalls.sh [STILLPOINTD] [SECONDS]`.
# Wanted: clock_nanosleep (until each step of the rehearsal that is still ahead, until the sample is due), and what Fast DDS does inside write(): for UDP one
# sendto and one setsockopt (its send time-out) a sample, and now and then a futex where another of its threads holds its lock.
# The trace slows the thread to some hundred samples a second, which leaves no time for rehearsals.
# Reading the clock is no system call (vDSO). Needs strace. Exit 1 when the thread makes a call of its own beside the pacing.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
daemon=${1:-$root/build/release/stillpointd}
seconds=${2:-5}
[ -x "$daemon" ] || { echo "usage: bench/syscalls.sh [STILLPOINTD] [SECONDS]; $daemon is no program; build it first" >&2; exit 64; }
command -v strace >/dev/null || { echo "strace is not installed: apt-get install strace" >&2; exit 69; }
work=$(mktemp -d)
domain=$((1 + $$ % 100))
pid= subscriber= watcher=
trap 'kill $pid $subscriber $watcher 2>/dev/null || true; rm -rf "$work"' EXIT
cat >"$work/d.yaml" <<YAML
source: {kind: simulation, file: $root/configs/sim_handheld.yaml, speed: 10}
dds: {domain: $domain}
YAML
"$daemon" --config "$work/d.yaml" 2>"$work/log" &
pid=$!
# A subscriber, so that the write has somebody to send to.
"$(dirname "$daemon")/stillpoint" record --domain "$domain" --output "$work/r.csv" >"$work/record.log" 2>&1 &
subscriber=$!
"$(dirname "$daemon")/stillpoint" watch --domain "$domain" >"$work/watch.log" 2>&1 &
watcher=$!
sleep 2
thread=$(grep -lx sensor /proc/"$pid"/task/*/comm | cut -d/ -f5)
timeout -s INT "$seconds" strace -qq -k -o "$work/trace" -p "$thread" || true
# strace -k prints the stack below each call. Ours: every call that is not the pacing and has no frame of Fast DDS.
awk '/^[a-z_0-9]+\(/ { if (name != "") print name, (inside ? "inside Fast DDS" : "ours"); split($0, part, "("); name = part[1]; inside = 0 }
     /libfastrtps/ { inside = 1 }' "$work/trace" | sort | uniq -c | sort -rn | tee "$work/calls"
[ -s "$work/calls" ] || { echo "no call was traced" >&2; exit 69; }
if grep ' ours$' "$work/calls" | grep -vE ' (clock_nanosleep|restart_syscall) ' >&2; then
  echo "the calls above are ours and neither the pacing nor the write" >&2
  exit 1
fi
echo "nothing but the pacing and Fast DDS's write"

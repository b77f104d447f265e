#!/usr/bin/env bash
# The unit and the user that it runs as, judged by systemd's own tools, without a running systemd. Code 77: skipped.
set -euo pipefail
folder=$(cd "$(dirname "$0")/../../packaging" && pwd)
for tool in systemd-analyze systemd-sysusers; do
  command -v "$tool" >/dev/null || { echo "LOUD: SKIPPED: no $tool here (apt-get install systemd)" >&2; exit 77; }
done
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# The programs and the manual are not installed here.
sed 's#/usr/bin/stillpointd#/bin/true#; /^Documentation=/d' "$folder/stillpointd.service" >"$scratch/stillpointd.service"
said=$(systemd-analyze verify "$scratch/stillpointd.service" 2>&1 | grep stillpointd || true)
[ -z "$said" ] || { echo "systemd-analyze verify: $said" >&2; exit 1; }

level=$(systemd-analyze security --offline=true --threshold=25 "$folder/stillpointd.service" 2>/dev/null |
  sed -n 's/.*Overall exposure level[^:]*: *\([0-9.]*\).*/\1/p')
echo "exposure level $level (limit 2.5)"
systemd-analyze security --offline=true --threshold=25 "$folder/stillpointd.service" >/dev/null 2>&1 ||
  { echo "exposure level $level is above 2.5" >&2; exit 1; }

mkdir -p "$scratch/tree/etc"
printf 'dialout:x:20:\n' >"$scratch/tree/etc/group"
systemd-sysusers --root="$scratch/tree" "$folder/stillpointd.sysusers" 2>&1
grep -q '^stillpoint:' "$scratch/tree/etc/passwd"
grep -q '^dialout:.*stillpoint' "$scratch/tree/etc/group"

for line in Type=notify 'ExecReload=/bin/kill -HUP \$MAINPID' StartLimitIntervalSec=0 IPAddressDeny=any Restart=always; do
  grep -q "^$line\$" "$folder/stillpointd.service" || { echo "the unit lacks $line" >&2; exit 1; }
done

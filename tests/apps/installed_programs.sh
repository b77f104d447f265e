#!/usr/bin/env bash
# What `cmake --install` puts under a prefix runs from there: installed_programs.sh BUILD_FOLDER
set -euo pipefail
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT
cmake --install "$1" --prefix "$prefix" > /dev/null
[ "$(find "$prefix" -name stillpoint.idl -o -name stillpointd.service -o -name daemon.md | wc -l)" -eq 3 ]
cd "$prefix"
for config in share/stillpoint/configs/{simulated,real_time,estimate}.yaml; do bin/stillpointd --check-config --config "$config"; done
# The simulation of the demo must be the installed one.
echo 'broken: true' > share/stillpoint/configs/sim_handheld.yaml
if bin/stillpoint demo 2> said; then echo "the demo did not read the installed simulation"; exit 1; fi
grep -q "sim_handheld.yaml:1:1: unknown key 'broken'" said

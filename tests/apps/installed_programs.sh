#!/usr/bin/env bash
# What `cmake --install` puts under a prefix runs from there: installed_programs.sh BUILD_FOLDER
set -euo pipefail
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT
cmake --install "$1" --prefix "$prefix" > /dev/null
[ "$(find "$prefix" -name stillpoint.idl -o -name stillpointd.service -o -name daemon.md | wc -l)" -eq 3 ]
cd "$prefix"
for config in share/stillpoint/configs/{simulated,real_time}.yaml; do bin/stillpointd --check-config --config "$config"; done
bin/stillpoint check share/stillpoint/configs/estimate.yaml > /dev/null
# The simulation of the demo must be the installed one.
echo 'broken: true' > share/stillpoint/configs/sim_handheld.yaml
if bin/stillpoint demo 2> said; then echo "the demo did not read the installed simulation"; exit 1; fi
grep -q "sim_handheld.yaml:1:1: unknown key 'broken'" said
# A slip of the finger is named.
code=0
bin/stillpoint diagnose --simulaton x 2> said || code=$?
[ "$code" -eq 64 ]
grep -q "did you mean '--simulation'?" said
# What other programs wrote is read, and what the programs say of themselves is installed.
printf 't,ax,ay,az\n' > foreign.csv
for i in $(seq 0 50); do echo "0.$((100 + i)),0,0.01,1.001"; done >> foreign.csv
bin/stillpoint import foreign.csv --output ours.csv 2> said
grep -q 'looks like g: median norm 1.001' said
grep -q '^time_ns,acc_x_mps2' ours.csv
zcat share/man/man1/stillpoint.1.gz > page
grep -q '^\.SS import' page
grep -q -- '--simulation' share/bash-completion/completions/stillpoint

#!/usr/bin/env bash
# The driver finds a planted defect, keeps the input that shows it, and that input shows it again: driver_test.sh TEST_FUZZ
set -euo pipefail
fuzz=$1
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
wrong() { echo "FAILED: $*" >&2; cat "$scratch/log" >&2; exit 1; }

mkdir "$scratch/inputs" "$scratch/kept"
printf 'a point' > "$scratch/inputs/one"
printf '# words\n"still "\nname="\\x70oint"\n' > "$scratch/words"
run() { "$fuzz" planted "-artifact_prefix=$scratch/kept/" "$@" > "$scratch/log" 2>&1; }

run -runs=50 "$scratch/inputs/one" || wrong "a file is replayed, and nothing else"
grep -q '^Done 1 runs in ' "$scratch/log" || wrong "the runs are counted"
run -runs=500 "$scratch/inputs" || wrong "without the words nobody finds it"
grep -q '^Done 500 runs in ' "$scratch/log" || wrong "a folder's inputs are damaged, so many times"
run -max_total_time=60 "-dict=$scratch/words" "$scratch/inputs" && wrong "the planted defect was not found"
grep -q 'promise broken: no input says it' "$scratch/log" || wrong "it ended for another reason"
kept=$(ls "$scratch"/kept/crash-*) || wrong "no input was kept"
grep -q 'still point' "$kept" || wrong "another input was kept"
run "$kept" && wrong "the kept input does not show it again"

printf 'for ever' > "$scratch/inputs/two"
run -timeout=1 "$scratch/inputs/two" && wrong "what never ends was waited for"
cmp "$scratch"/kept/timeout-* "$scratch/inputs/two" || wrong "the input that never ends was not kept"
if run -no_such_option=1 "$scratch/inputs"; then wrong "an option that nobody knows was taken"; fi

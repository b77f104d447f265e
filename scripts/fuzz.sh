#!/usr/bin/env bash
# Runs every fuzzing harness of tests/fuzz for a while, two at once, and counts. What ends one is kept in the build folder.
#   scripts/fuzz.sh SECONDS [PRESET]     SECONDS a harness; PRESET dev (default) or libfuzzer (clang)
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh
case "${1:-}" in
  "" | *[!0-9]*) echo "usage: scripts/fuzz.sh SECONDS [dev | libfuzzer]" >&2; exit 64 ;;
esac
export seconds=$1 preset=${2:-dev}
build "$preset" fuzz
export folder=$PWD/build/$preset/fuzz
mkdir -p "$folder"

# one LINE of the list: NAME, program, inputs. What libFuzzer finds of new inputs goes into a folder of its own.
one() {
  local name command inputs
  IFS=$'\t' read -r name command inputs <<< "$1"
  mkdir -p "$folder/found/$name"
  # shellcheck disable=SC2086  # words
  $command -seed="${seed:-$RANDOM}" -max_total_time="$seconds" -artifact_prefix="$folder/$name-" "$folder/found/$name" $inputs > "$folder/$name.log" 2>&1 || true
  if grep -q '^Done [0-9]* runs' "$folder/$name.log"; then
    echo "$name $(sed -n 's/^Done \([0-9]*\) runs.*/\1/p' "$folder/$name.log")"
  else
    echo "$name FAILED"
    grep -E 'ERROR|runtime error|promise|written to|not one of' "$folder/$name.log" | sed "s/^/  /" >&2
  fi
}
export -f one

say "$(wc -l < "$folder/commands") harnesses, $seconds s each, two at once"
tr '\n' '\0' < "$folder/commands" | xargs -0 -n 1 -P 2 bash -c 'one "$1"' _ | tee "$folder/counts"
awk '{ runs += $2; failed += $2 == "FAILED" } END { printf "==> %d executions, %d harnesses failed\n", runs, failed; exit failed > 0 }' "$folder/counts"

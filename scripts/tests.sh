#!/usr/bin/env bash
# Runs the tests of a preset: scripts/tests.sh PRESET [OPTION of ctest...]. What was skipped, and why, stands at the end:
# ctest shows what a test printed only where it failed.
set -uo pipefail
cd "$(dirname "$0")/.."
ctest --preset "$@"
status=$?
grep -ho 'LOUD: .*' "build/${1/#long/release}/Testing/Temporary/LastTest.log" | sort -u
exit "$status"

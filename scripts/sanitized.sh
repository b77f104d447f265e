#!/usr/bin/env bash
# Builds the tests under a sanitizer and runs them: tsan (what has threads), dev (ASan and UBSan, all but the tool) or
# tool (the same over the tool and its searches, which take ten times as long as all the rest).
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh
jobs=$(($(nproc) + 1))
tool='^(test_)?(apps|diagnosis)[._]|^installed_programs$'
case "${1:-}" in
  tsan)
    build tsan test_threads test_daemon_threads
    scripts/tests.sh tsan ;;
  dev)
    build dev tests_without_tool
    scripts/tests.sh dev -j"$jobs" -E "$tool" ;;
  tool)
    build dev all test_diagnosis
    scripts/tests.sh dev -j"$jobs" -R "$tool" ;;
  *) echo "usage: scripts/sanitized.sh tsan | dev | tool" >&2; exit 64 ;;
esac

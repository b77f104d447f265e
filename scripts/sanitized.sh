#!/usr/bin/env bash
# Builds the tests under a sanitizer and runs them: tsan (what has threads), dev (ASan and UBSan, all but the tool) or
# tool (all three over the tool and its searches, which take ten times as long as all the rest).
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
    scripts/tests.sh dev -j"$jobs" -R "$tool"
    build tsan test_diagnosis  # the sensors are searched beside one another
    TSAN_OPTIONS="suppressions=$PWD/cmake/tsan.supp halt_on_error=1" build/tsan/tests/test_diagnosis --gtest_filter='GoldenAnswers*' ;;
  *) echo "usage: scripts/sanitized.sh tsan | dev | tool" >&2; exit 64 ;;
esac

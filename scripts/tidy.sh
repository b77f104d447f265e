#!/usr/bin/env bash
# clang-tidy over every source of ours; any finding fails. Needs build/release (for its compile commands).
set -euo pipefail
cd "$(dirname "$0")/.."
git ls-files 'core/*.cpp' 'io/*.cpp' 'simulation/*.cpp' 'calib_online/*.cpp' 'fusion/*.cpp' 'pipeline/*.cpp' \
  'diagnosis/*.cpp' 'apps/*.cpp' | xargs -P 2 -n 4 clang-tidy -p build/release --quiet

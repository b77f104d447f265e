#!/usr/bin/env bash
# clang-tidy over every source of ours; any finding fails. Needs build/release (for its compile commands).
set -euo pipefail
cd "$(dirname "$0")/.."
# Of how GCC compiles, without its precompiled headers and the warnings that only GCC has.
mkdir -p build/tidy
sed -E 's/ -Winvalid-pch//g; s/ -include [^ ]*cmake_pch\.hxx//g; s/ -Wno-(restrict|stringop-[a-z]+)//g' \
  build/release/compile_commands.json >build/tidy/compile_commands.json
git ls-files 'core/*.cpp' 'io/*.cpp' 'simulation/*.cpp' 'calib_online/*.cpp' 'fusion/*.cpp' 'pipeline/*.cpp' \
  'diagnosis/*.cpp' 'sources/*.cpp' 'exchange/*.cpp' 'laws/*.cpp' 'report/*.cpp' 'c_api/*.cpp' 'apps/*.cpp' |
  xargs -P 2 -n 4 clang-tidy -p build/tidy --quiet

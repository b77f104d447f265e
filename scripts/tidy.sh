#!/usr/bin/env bash
# clang-tidy over the sources of the libraries, the daemon and the tool, not of bench/, examples/, python/ and tests/; any
# finding fails. Needs build/release (for what its build generates).
set -euo pipefail
cd "$(dirname "$0")/.."
# Of how GCC compiles, every source alone and without precompiled headers and the warnings that only GCC has.
cmake --preset release -B build/tidy -DCMAKE_UNITY_BUILD=OFF -DSTILLPOINT_PRECOMPILED=OFF >/dev/null
sed -i -E 's/ -Wno-(restrict|stringop-[a-z]+)//g; s#/build/tidy/#/build/release/#g' build/tidy/compile_commands.json
git ls-files 'core/*.cpp' 'io/*.cpp' 'simulation/*.cpp' 'calib_online/*.cpp' 'fusion/*.cpp' 'pipeline/*.cpp' \
  'diagnosis/*.cpp' 'sources/*.cpp' 'exchange/*.cpp' 'laws/*.cpp' 'report/*.cpp' 'c_api/*.cpp' 'apps/*.cpp' |
  xargs -P 2 -n 4 clang-tidy -p build/tidy --quiet

#!/usr/bin/env bash
# The examples, built and run against an installed tree: installed_library.sh BUILD_FOLDER SOURCE_FOLDER
set -euo pipefail
build=$1 source=$2
work=$(mktemp -d)
daemon=
trap '[ -z "$daemon" ] || kill "$daemon" 2> /dev/null; rm -rf "$work"' EXIT
expect() { grep -q "$2" <<< "$1" || { echo "wanted: $2"; echo "got: $1"; exit 1; }; }

for component in dev libraries; do
  cmake --install "$build" --prefix "$work/prefix" --component $component > /dev/null
done
cmake -S "$source/examples" -B "$work/examples" -G Ninja -DCMAKE_PREFIX_PATH="$work/prefix" > "$work/log" 2>&1 ||
  { cat "$work/log"; exit 1; }
cmake --build "$work/examples" -j2 > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }

# 0.1 rad/s for 10 s are 57.3 deg.
expect "$("$work/examples/filter_only")" '^yaw 57\.[23] deg'
expect "$("$work/examples/calibration_only")" 'bias 0\.0\(20\|199\)[0-9]* -0\.0\(10\|099\)[0-9]* .*: ok$'

readings() {
  awk 'BEGIN { srand(1); for (i = 0; i < 3000; ++i) printf "%.3f %.4f %.4f %.4f %.5f %.5f %.5f\n", i / 100,
       0.02 * (rand() - 0.5), 0.02 * (rand() - 0.5), 9.80665 + 0.02 * (rand() - 0.5),
       0.02 + 0.002 * (rand() - 0.5), 0.002 * (rand() - 0.5), 0.002 * (rand() - 0.5) }'
}
expect "$(readings | "$work/examples/attitude")" 'status 1, gyroscope bias 0\.0\(200\|199\)'

# The C program again, by pkg-config; the C library needs none of the C++ ones.
export PKG_CONFIG_PATH=$(dirname "$(find "$work/prefix" -name stillpoint_c.pc)")
cc -std=c99 -Wall -Wextra -Wpedantic -Werror "$source/examples/attitude.c" $(pkg-config --cflags --libs stillpoint_c) -o "$work/attitude_pc"
export LD_LIBRARY_PATH=$(pkg-config --variable=libdir stillpoint_c)
expect "$(readings | "$work/attitude_pc")" 'status 1'
if ldd "$work/attitude_pc" | grep -E 'yaml|fmt|crypto|fastrtps'; then echo "the C library drags these in"; exit 1; fi
c++ -fsyntax-only $(pkg-config --cflags stillpoint) -include stillpoint/diagnosis/diagnose.h -x c++ /dev/null

if [ -x "$work/examples/subscriber" ] && [ -x "$build/stillpointd" ]; then
  "$build/stillpointd" --config "$source/configs/simulated.yaml" > "$work/daemon" 2>&1 &
  daemon=$!
  expect "$("$work/examples/subscriber")" 'attitudes in 5 s'
else
  echo "the subscriber's example was not run: no DDS in this build"
fi

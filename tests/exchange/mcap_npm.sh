#!/usr/bin/env bash
# An MCAP file of ours, read by the format's own library and by Foxglove's ROS 2 decoder: mcap_npm.sh TEST_EXCHANGE
set -euo pipefail
if ! command -v npm > /dev/null || ! command -v node > /dev/null; then
  echo "LOUD: no npm here: the check of MCAP files by @mcap/core is SKIPPED"
  exit 0
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
TEST_TMPDIR=$work/ "$1" --gtest_filter='Import.AnMcapFileOfOursComesBackBitForBitAndWholeChunksSurviveACut' > /dev/null
cp "$(dirname "$0")/read_mcap.mjs" "$work"
cd "$work"
if ! npm install --no-audit --no-fund --silent @mcap/core@2 @foxglove/rosmsg@5 @foxglove/rosmsg2-serialization@3 > log 2>&1; then
  tail -3 log
  echo "LOUD: npm cannot fetch its packages: the check of MCAP files by @mcap/core is SKIPPED"
  exit 0
fi
node read_mcap.mjs ours.mcap indexed
node read_mcap.mjs cut.mcap streamed

#!/bin/sh
# Corrections as a servo task would compute them, every millisecond.
#   ABBE=path/to/abbe ./demo.sh      results go to out/ beside this script
# The program real_time is built with the tests; by hand: cmake -S . -B build, see CMakeLists.txt.
set -eu
abbe=${ABBE:-abbe}
case $abbe in
  */*) real_time=$(dirname "$abbe")/real_time ;;
  *) real_time=real_time ;;
esac
command -v "$real_time" >/dev/null || { echo "demo.sh: no program '$real_time'; build it first" >&2; exit 2; }
case $real_time in
  /*) ;;
  */*) real_time=$PWD/$real_time ;;
esac
cd "$(dirname "$0")"
mkdir -p out

echo "--- A five-axis machine: 1 s at one place, 1 s along a line (position in mm or rad, correction)"
"$real_time" machine.toml | tee out/corrections.txt

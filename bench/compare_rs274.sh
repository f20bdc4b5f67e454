#!/usr/bin/env bash
# How long does it take to compensate a program, compared with LinuxCNC's interpreter merely reading it?
#   bench/compare_rs274.sh [LINES] [ROUNDS]          default 1000000 lines, best of 5
# Both run on one core, in turn, so that a busy machine disturbs both. `abbe compensate` reads, corrects,
# writes, reads both programs again for verification, and publishes; `rs274 -g` reads and prints its
# canonical commands. Needs build/release (./run test, or cmake --workflow --preset release),
# linuxcnc-uspace and GNU time.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
lines=${1:-1000000} rounds=${2:-5}
build=${BUILD:-build/release}

need() { [ -x "$1" ] || { echo "compare_rs274.sh: $1 is missing: $2" >&2; exit 2; }; }
need "$build/abbe" "cmake --workflow --preset release"
need "$build/generate_program" "cmake --workflow --preset release"
need /usr/bin/rs274 "apt-get install linuxcnc-uspace"
need /usr/bin/time "apt-get install time"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$build/generate_program" "$lines" >"$scratch/part.ngc"
: >"$scratch/rs274.var"

# timed NAME COMMAND...: appends "wall-seconds peak-KiB processor-seconds" to NAME.times
timed() {
  local name=$1
  shift
  if ! HOME=$scratch /usr/bin/time -v -o "$scratch/$name.time" taskset -c 0 "$@" >"$scratch/$name.log" 2>&1; then
    echo "compare_rs274.sh: failed: $*" >&2
    tail -n 20 "$scratch/$name.log" >&2
    exit 1
  fi
  awk '/Elapsed/ { n = split($NF, part, ":"); for (i = 1; i <= n; i++) wall = wall * 60 + part[i] }
       /Maximum resident/ { peak = $NF } /User time|System time/ { used += $NF } END { print wall, peak, used }' "$scratch/$name.time" >>"$scratch/$name.times"
}

for _ in $(seq "$rounds"); do
  timed abbe "$build/abbe" compensate bench/machine.toml "$scratch/part.ngc" -o "$scratch/out.ngc" --offset G54=X0,Y0,Z0
  timed rs274 rs274 -v "$scratch/rs274.var" -g "$scratch/part.ngc" "$scratch/canon.txt"
done

bytes=$(stat -c %s "$scratch/part.ngc")
# By the clock and by processor time, which does not wait for the disk: best of each.
for name in abbe rs274; do
  awk 'NR == 1 || $1 < wall { wall = $1 } NR == 1 || $2 > peak { peak = $2 } NR == 1 || $3 < used { used = $3 }
       END { print wall, used, peak }' "$scratch/$name.times"
done >"$scratch/best"
awk -v lines="$lines" -v bytes="$bytes" -v rounds="$rounds" '
  NR == 1 { name = "abbe compensate"; ours = $1; used = $2 }
  NR == 2 { name = "rs274 -g" }
  { printf "%-16s %6.2f s clock %6.2f s processor %12.0f lines/s %8.1f MB/s %8.1f MB peak\n", name, $1, $2, lines / $1, bytes / 1e6 / $1, $3 / 1024 }
  END { printf "rs274 / abbe     %6.2f         %6.2f   (%d lines, %.1f MB, best of %d, one core each)\n", $1 / ours, $2 / used, lines, bytes / 1e6, rounds }
' "$scratch/best"

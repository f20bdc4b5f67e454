#!/usr/bin/env bash
# How long does it take to compensate a program, compared with LinuxCNC's interpreter merely reading it?
#   bench/compare_rs274.sh [LINES] [ROUNDS] [KIND]    default 1000000 lines, best of 5, kind mill
# KIND is the program: mill (three axes, arcs), or of five axes smooth (as from a CAM system) or random
# (magnitudes, steps and decimals drawn for every word: defeats branch prediction).
# Both run on one core, in turn, so that a busy machine disturbs both. `abbe compensate` reads, corrects,
# writes, reads both programs again for verification, and publishes; `rs274 -g` reads and prints its
# canonical commands. A further row is the rewriter alone from memory to memory, and one more
# abbe compensate on all processors. Needs build/release (./run test, or cmake --workflow --preset release),
# linuxcnc-uspace and GNU time.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
lines=${1:-1000000} rounds=${2:-5} kind=${3:-mill}
build=${BUILD:-build/release}

need() { [ -x "$1" ] || { echo "compare_rs274.sh: $1 is missing: $2" >&2; exit 2; }; }
need "$build/abbe" "cmake --workflow --preset release"
need "$build/generate_program" "cmake --workflow --preset release"
need "$build/bench/program_times" "cmake --workflow --preset release"
need "$build/bench/generate_five_axis" "cmake --workflow --preset release"
need /usr/bin/rs274 "apt-get install linuxcnc-uspace"
need /usr/bin/time "apt-get install time"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
case $kind in
  mill)
    machine=bench/machine.toml
    "$build/generate_program" "$lines" >"$scratch/part.ngc" ;;
  smooth | random)
    machine=$scratch/machine.toml
    "$build/bench/generate_five_axis" machine >"$machine"
    "$build/bench/generate_five_axis" "$kind" "$lines" >"$scratch/part.ngc" ;;
  *) echo "compare_rs274.sh: $kind is no kind of program: mill, smooth or random" >&2; exit 2 ;;
esac
: >"$scratch/rs274.var"

# timed NAME PROCESSORS COMMAND...: appends "wall-seconds peak-KiB processor-seconds" to NAME.times
timed() {
  local name=$1 processors=$2
  shift 2
  if ! HOME=$scratch /usr/bin/time -v -o "$scratch/$name.time" taskset -c "$processors" "$@" >"$scratch/$name.log" 2>&1; then
    echo "compare_rs274.sh: failed: $*" >&2
    tail -n 20 "$scratch/$name.log" >&2
    exit 1
  fi
  awk '/Elapsed/ { n = split($NF, part, ":"); for (i = 1; i <= n; i++) wall = wall * 60 + part[i] }
       /Maximum resident/ { peak = $NF } /User time|System time/ { used += $NF } END { print wall, peak, used }' "$scratch/$name.time" >>"$scratch/$name.times"
}

for _ in $(seq "$rounds"); do
  compensate=("$build/abbe" compensate "$machine" "$scratch/part.ngc" -o "$scratch/out.ngc" --offset "G54=X0,Y0,Z0")
  timed abbe 0 "${compensate[@]}"
  timed abbe2 "0-$(($(nproc) - 1))" "${compensate[@]}"
  timed rs274 0 rs274 -v "$scratch/rs274.var" -g "$scratch/part.ngc" "$scratch/canon.txt"
done

bytes=$(stat -c %s "$scratch/part.ngc")
taskset -c 0 "$build/bench/program_times" "$machine" "$scratch/part.ngc" "$rounds" >"$scratch/memory"
# By the clock and by processor time, which does not wait for the disk: best of each.
for name in abbe abbe2 rs274; do
  awk 'NR == 1 || $1 < wall { wall = $1 } NR == 1 || $2 > peak { peak = $2 } NR == 1 || $3 < used { used = $3 }
       END { print wall, used, peak }' "$scratch/$name.times"
done >"$scratch/best"
awk -v lines="$lines" -v bytes="$bytes" -v rounds="$rounds" -v memory="$(awk '{ print $7 }' "$scratch/memory")" '
  NR == 1 { name = "one processor"; ours = $1; used = $2 }
  NR == 2 { name = "all processors"; both = $1 }
  NR == 3 { name = "rs274 -g" }
  { printf "%-16s %6.2f s clock %6.2f s processor %12.0f lines/s %8.1f MB/s %8.1f MB peak\n", name, $1, $2, lines / $1, bytes / 1e6 / $1, $3 / 1024 }
  END {
    printf "%-16s                %6.2f s processor\n", "memory", memory
    printf "rs274 / abbe     %6.2f by the clock, %.2f by processor time, %.2f from memory to memory; all processors %.2f of one\n", $1 / ours, $2 / used, $2 / memory, ours / both
    printf "(%d lines, %.1f MB, best of %d)\n", lines, bytes / 1e6, rounds
  }
' "$scratch/best"

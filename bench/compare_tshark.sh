#!/usr/bin/env bash
# How long does it take to decode an EtherCAT capture, compared with tshark printing the fields needed for it?
#   bench/compare_tshark.sh [FRAMES] [ROUNDS]          default 1000000 frames, best of 5 (tshark: of 2)
# Processor time, in turn. abbe gives columns of numbers; what tshark prints would still have to be unpacked.
# Needs build/release (cmake --workflow --preset release), tshark and GNU time.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
frames=${1:-1000000} rounds=${2:-5}
build=${BUILD:-build/release}
for program in "$build/bench/capture_times" tshark /usr/bin/time; do
  command -v "$program" >/dev/null || { echo "compare_tshark.sh: $program is missing" >&2; exit 2; }
done

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
capture=$scratch/circle.pcap
"$build/bench/capture_times" "$capture" "$frames" 1 >/dev/null
for _ in 1 2; do
  "$build/bench/capture_times" "$capture" "$frames" "$rounds" >>"$scratch/ours"
  /usr/bin/time -f '%U %S' -o "$scratch/time" tshark -n -r "$capture" -T fields -e frame.time_epoch -e ecat.cmd \
    -e ecat.data -e ecat.cnt >/dev/null 2>&1
  cat "$scratch/time" >>"$scratch/theirs"
done
awk -v frames="$frames" '
  FILENAME ~ /ours$/ { if (ours == "" || $2 < ours) ours = $2; if (survey == "" || $4 < survey) survey = $4 }
  FILENAME ~ /theirs$/ { t = $1 + $2; if (theirs == "" || t < theirs) theirs = t }
  END {
    printf "abbe decode      %8.1f ns/frame (and %.1f ns for the survey before it)\n", ours / frames * 1e9, survey / frames * 1e9
    printf "tshark -T fields %8.1f ns/frame\nratio            %8.1f\n", theirs / frames * 1e9, theirs / ours
  }' "$scratch/ours" "$scratch/theirs"

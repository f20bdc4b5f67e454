#!/bin/sh
# CL data before the post-processor, or without one.
#   ABBE=path/to/abbe ./demo.sh      results go to out/ beside this script
set -eu
abbe=${ABBE:-abbe}
command -v "$abbe" >/dev/null || { echo "demo.sh: no program '$abbe'; set ABBE to the path of abbe" >&2; exit 2; }
case $abbe in
  /*) ;;
  */*) abbe=$PWD/$abbe ;;
esac
cd "$(dirname "$0")"
mkdir -p out
setup="--gauge T3=150,T4=120 --near A=30 --circle-hand right"

echo "--- A circle of this CAM system: which way round? It must be said"
"$abbe" check machine.toml blade.cls --gauge T3=150,T4=120 --near A=30 2>&1 | grep -e error -e fix || true

echo
echo "--- Corrected tips and tool axes, for the machine's post-processor"
"$abbe" compensate machine.toml blade.cls -o out/blade.cls $setup --report out/report.json 2>&1

echo
echo "--- One record"
"$abbe" explain machine.toml blade.cls:16 $setup 2>&1

echo
echo "--- A second opinion on two files"
"$abbe" verify machine.toml blade.cls out/blade.cls $setup 2>&1 | head -n 4

echo
echo "--- No post-processor: axis words, errors already in them"
"$abbe" inverse machine.toml --poses blade.cls --emit gcode -o out/blade.ngc $setup --tolerance-um 5 2>&1
grep -v '^(ABBE' out/blade.ngc | head -n 12

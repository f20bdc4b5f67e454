#!/bin/sh
# A machine that gets warm, and has no axis in one direction.
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

position=X=300,Z=-100,C=40
for temperature in 20 30 40; do
  echo "--- Table, drives and spindle at $temperature degC"
  warm=T1=$temperature,T2=$temperature,T3=$temperature
  "$abbe" predict machine.toml --at $position --set $warm
  "$abbe" predict machine.toml --at $position --set $warm --json > out/predict-$temperature.json
  echo
done

echo "--- What X and Z can do about it at 40 degC (the warning says that something remains)"
"$abbe" correct machine.toml --at $position --set T1=40,T2=40,T3=40 2>&1

echo
echo "--- A shift: the temperatures are columns of the points"
"$abbe" correct machine.toml --points shift.csv 2>&1

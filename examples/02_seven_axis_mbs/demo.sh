#!/bin/sh
# A machine with more axes than a tool pose has coordinates: which ones correct?
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

position=X=-420.5,Y=350.25,Z=180.75,Z1=60.125,A=12,B=-25,B1=30

echo "--- Where the drill really is; accepted are 20 um and 0.015 deg"
"$abbe" predict machine.toml --at $position --limit-um 20 --limit-angle-deg 0.015

echo
echo "--- Z1 feeds the drill and B1 indexes the panel: names with a digit stay at their command"
"$abbe" correct machine.toml --at $position --limit-um 20 --limit-angle-deg 0.015

echo
echo "--- All seven axes, the smallest weighted motion: 1 mm of Z1 costs as much as 10 mm of X, a turn of A,"
echo "    B or B1 as much as the way of a point 300 mm away (3000 mm for B1)"
"$abbe" correct machine.toml --at $position --weights X=1,Y=1,Z=1,A=300,B=300,Z1=10,B1=3000

echo
echo "--- The two ways to the commands, over 24 holes of a panel (results in out/)"
for method in newton closed-form; do
  "$abbe" correct machine.toml --points holes.csv --method $method --json > out/$method.json
  "$abbe" correct machine.toml --points holes.csv --method $method | tail -n 1
done
"$abbe" describe machine.toml --json > out/describe.json

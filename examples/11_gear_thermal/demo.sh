#!/bin/sh
# A gear that is milled while the machine gets warm.
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
cut="$abbe gear cut machine.toml gear.toml"

echo "--- The gear, its cutter and its tolerances"
"$abbe" gear make gear.toml --profile out/cutter.csv

echo
echo "--- On the cold machine"
$cut --set T1=20,T2=20,T3=20 | sed -n '/^all teeth/,$p'

echo
echo "--- Cut in three hours from cold to warm"
$cut --course course.csv --svg out/before.svg --cl out/gear.cls | sed -n '/^machine/,$p'

echo
echo "--- The cutter brought back to its pose as far as X, Z and C can"
$cut --course course.csv --correct pose 2>&1 | sed -n '/^all teeth/,$p;/W-GEAR/p'

echo
echo "--- X, Z and C sent so that the flanks come out best"
$cut --course course.csv --correct flank --svg out/after.svg --motions out/motions.csv | sed -n '/^tooth/,$p'

echo
echo "--- Which of the errors is it? One by one, over the same three hours"
"$abbe" gear sensitivity machine.toml gear.toml --course course.csv

echo
echo "--- The program of the ideal machine"
"$abbe" inverse machine.toml --poses out/gear.cls --set T1=20,T2=20,T3=20 --ideal --emit gcode -o out/gear.ngc 2>&1
head -n 12 out/gear.ngc | tail -n 6

#!/bin/sh
# Five axes: exact commands for a tool path, the printed equations, the pole, measured deviations.
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

echo "--- Commands for one pose: ideal machine, then the real one"
pose=35.5,-62.25,48.75,0.4698463,0.1710101,0.8660254
"$abbe" inverse machine.toml --pose $pose --near A=30,C=-110 --ideal
"$abbe" inverse machine.toml --pose $pose --near A=30,C=-110 --method closed-form

echo
echo "--- Four methods at the ideal commands of that pose"
position=X=70.637581,Y=-112.068334,Z=21.955081,A=30,C=-110
for method in one-step printed newton closed-form; do
  printf '%-12s' $method
  "$abbe" correct machine.toml --at $position --method $method | grep '^remains'
done

echo
echo "--- Near the pole: the tool is almost parallel to C, A = 0.05 deg. C would have to turn by 2 deg"
"$abbe" correct machine.toml --at X=70,Y=-12,Z=48,A=0.05,C=-110 --method closed-form 2>&1
echo
"$abbe" correct machine.toml --at X=70,Y=-12,Z=48,A=0.05,C=-110 --method closed-form --max-rotary-correction 5

echo
echo "--- A tool path along a flank"
"$abbe" inverse machine.toml --poses flank.csv --near A=10,C=-150 --method closed-form | tail -n 2
"$abbe" inverse machine.toml --poses flank.csv --near A=10,C=-150 --method closed-form --json > out/flank.json

echo
echo "--- An inspection found deviations of gear and tool. The machine file has errors of both: which count?"
"$abbe" cl-correct machine.toml --pose $pose --near A=30,C=-110 --deviations inspection.csv 2>&1 || echo "exit code $?"
echo
"$abbe" cl-correct machine.toml --pose $pose --near A=30,C=-110 --deviations inspection.csv --sources both
"$abbe" cl-correct machine.toml --poses flank.csv --near A=10,C=-150 --deviations inspection.csv --sources both \
  -o out/flank_corrected.csv | tail -n 2

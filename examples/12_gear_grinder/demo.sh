#!/bin/sh
# A helical gear on a five-axis grinder: its flanks with and without corrected axes, and back from the flanks.
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
cut="$abbe gear cut machine.toml gear.toml --near A=90"

echo "--- The gear and the wheel for it"
"$abbe" gear make gear.toml --profile out/wheel.csv

echo
echo "--- Ground with the commands of the ideal machine"
$cut --svg out/before.svg --points out/measured.csv --cl out/nominal.cls | sed -n '/^machine/,$p'

echo
echo "--- Ground with commands from the closed form: position and direction of the wheel"
$cut --correct pose --method closed-form --svg out/after.svg --motions out/motions.csv | sed -n '/^all teeth/,$p'

echo
echo "--- Which of the 24 deviations of gear and wheel makes which deviation of the gear?"
"$abbe" gear sensitivity machine.toml gear.toml --near A=90 --of poses

echo
echo "--- The machine's errors are not known, but the gear was measured: four teeth, profiles and helices"
"$abbe" gear correct machine.toml gear.toml --near A=90 --measured out/measured.csv -o out/corrected.cls

echo
echo "--- The corrected poses as axis words of the ideal machine, nothing counted twice"
"$abbe" inverse machine.toml --poses out/corrected.cls --near A=75 --ideal --emit gcode -o out/corrected.ngc 2>&1
grep -m 1 -A 3 '^G0' out/corrected.ngc

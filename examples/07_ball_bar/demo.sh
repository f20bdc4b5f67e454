#!/bin/bash
# A mill is measured with a ball bar, identified, predicted and compensated.
#   ABBE=path/to/abbe ./demo.sh      results go to out/ beside this script
set -euo pipefail
abbe=${ABBE:-abbe}
command -v "$abbe" >/dev/null || { echo "demo.sh: no program '$abbe'; set ABBE to the path of abbe" >&2; exit 2; }
case $abbe in
  /*) ;;
  */*) abbe=$PWD/$abbe ;;
esac
cd "$(dirname "$0")"
mkdir -p out
plan=()
for radius in 100 150; do
  for feed in 600 2400 4800; do plan+=(--test "plane=XY,radius=$radius,feed=$feed,setup=a,samples=600"); done
done

echo "1. What would these circles tell?"
"$abbe" identifiability machine.toml "${plan[@]}" --rotation 0 | grep -A3 -E '^(EC0Y|EXX X\^2|DXX)|not seen'

echo "2. Measure (here: simulate, 0.1 um noise)"
"$abbe" simulate ballbar machine.toml --errors hidden.toml "${plan[@]}" --seed 4 --out out/xy_

echo "3. One circle by itself"
"$abbe" ballbar out/xy_2.csv --svg out/figure.svg | grep -E 'backlash|squareness|G CCW|unexplained'

echo "4. All of them together"
"$abbe" identify machine.toml out/xy_*.csv --rotation 0 -o out/errors.toml | grep -E 'EC0Y|lost motion|X\^2|rank|noise|4800|xy_3'

echo "5. Predict a point that was not measured, and the truth"
"$abbe" predict machine.toml --errors out/errors.toml --at X=70,Y=-60,Z=0 --approach X=+,Y=+ | grep deviation
"$abbe" predict machine.toml --errors hidden.toml --at X=70,Y=-60,Z=0 --approach X=+,Y=+ | grep deviation

echo "6. Compensate a program with the static part"
"$abbe" compensate machine.toml part.ngc -o out/part.ngc --errors out/errors.toml --offset G54=X0,Y0,Z0 | grep -iE 'before|after|deviation' | head -3

echo "7. The published method: what belongs to one test is refused"
"$abbe" identify machine.toml out/xy_1.csv --method paper -o out/paper.toml | grep -E 'd[xy]_XY|b_x1|f_x1|share'
"$abbe" compensate machine.toml part.ngc -o out/never.ngc --errors out/paper.toml --set t=0 --offset G54=X0,Y0,Z0 2>&1 | grep -o 'error.E-SCOPE.' || true

#!/bin/sh
# From instruments to parts: measure a machine, find its errors, correct a program, and look at what the machine cuts.
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

echo "--- 18 runs on a machine whose errors nobody knows: 17 targets, 5 runs each way, 0.3 um and 0.5 arcsec of noise"
"$abbe" simulate measurements job.toml --errors hidden.toml --targets 17 --runs 5 --seed 7 --force

echo
echo "--- What the positioning of X says by itself"
"$abbe" evaluate out/exx.csv --as positioning --svg out/exx.svg | head -16

echo
echo "--- The errors of the machine from all of them"
"$abbe" fit job.toml -o out/errors.toml

echo
echo "--- The part program, corrected by what was found"
"$abbe" compensate machine.toml part.ngc -o out/part.ngc --errors out/errors.toml \
  --offset G54=X30,Y30,Z-210 --tools tools.tbl --report out/report.json

echo
echo "--- On the hidden machine: the same programs judged by its true errors. What is left is the price of noise."
"$abbe" verify machine.toml part.ngc out/part.ngc --errors hidden.toml \
  --offset G54=X30,Y30,Z-210 --tools tools.tbl

#!/bin/sh
# From instruments to five-axis parts: measure a machine, find its errors, correct a program, look at what it cuts.
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

echo "--- 20 runs and an R-test of three balls at 30 angles each, on a machine whose errors nobody knows"
"$abbe" simulate measurements job.toml --errors hidden.toml --targets 17 --runs 5 --seed 7 --force

echo
echo "--- The errors of the machine from all of them: 20 functions, 11 location errors"
"$abbe" fit job.toml -o out/errors.toml --covariance | sed -n '1p;/location errors/,$p'

echo
echo "--- The part program, corrected by what was found"
"$abbe" compensate machine.toml part.ngc -o out/part.ngc --errors out/errors.toml \
  --offset G54=X0,Y0,Z-400 --tools tools.tbl --report out/report.json

echo
echo "--- On the hidden machine: the same programs judged by its true errors. What is left is the price of noise."
"$abbe" verify machine.toml part.ngc out/part.ngc --errors hidden.toml \
  --offset G54=X0,Y0,Z-400 --tools tools.tbl

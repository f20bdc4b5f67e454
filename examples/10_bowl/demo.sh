#!/bin/sh
# A bowl, cut by a machine with 21 errors: before, after one differential step, after Newton; then with what geometric
# compensation cannot know.
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
place="--offset G54=X120,Y-60,Z-150 --start X0,Y0,Z0"

echo "--- The tool path: ball of 3 mm, scallops of 4 um"
"$abbe" toolpath bowl.toml --scallop-um 4 -o out/bowl.ngc --cl out/bowl.cls

echo
echo "--- The program for this machine: compensated by Newton's method, verified"
"$abbe" compensate machine.toml out/bowl.ngc $place -o out/newton.ngc --header none --report out/report.json >out/compensate.txt
grep agree out/compensate.txt

# One differential step, the paper's method: commands of every block, and of the datum first, through `correct`.
awk 'BEGIN { print "X,Y,Z"; print "120,-60,-150" }
  /^G[01] / { for (i = 2; i <= NF; ++i) v[substr($i, 1, 1)] = substr($i, 2)
              printf "%.4f,%.4f,%.4f\n", v["X"] + 120, v["Y"] - 60, v["Z"] - 150 }' out/bowl.ngc >out/commands.csv
"$abbe" correct machine.toml --points out/commands.csv --method one-step >out/one_step.txt
awk 'BEGIN { n = 0 }
  NR == FNR { if ($NF == "ok") { x[n] = $1; y[n] = $3; z[n++] = $5 } next }
  /^G[01] / { ++k; f = $NF ~ /^F/ ? " " $NF : ""
              printf "%s X%.4f Y%.4f Z%.4f%s\n", $1, x[k] - x[0], y[k] - y[0], z[k] - z[0], f; next }
  { print }' out/one_step.txt out/bowl.ngc >out/one_step.ngc

# Some of the figures, with one digit.
tell() { awk -v names="^($1)$" '$1 ~ names { printf "  %-8s %6.1f um\n", $1, $2 }'; }

echo
echo "--- What cutter and path alone leave, at 100 points"
"$abbe" machine machine.toml out/bowl.ngc $place --surface bowl.toml --ideal | tell "mean|most|linear"

echo
echo "--- What the machine makes of it, on a measuring machine that trusts the datum"
"$abbe" machine machine.toml out/bowl.ngc $place --surface bowl.toml -o out/before.csv >out/before.txt
"$abbe" inspect bowl.toml out/before.csv --svg out/before.svg | tell "mean|rms|profile|linear"
echo "after a best fit:"
"$abbe" inspect bowl.toml out/before.csv --fit rigid | tell "rms|profile|linear"

# mean distance of measured and target point, um: PROGRAM MACHINE [options]
linear() {
  program=$1 machine=$2
  shift 2
  "$abbe" machine "$machine" "$program" $place --surface bowl.toml "$@" | awk '$1 == "linear" { print $2 }'
}
row() {
  name=$1
  shift
  echo "$name|$(linear out/bowl.ngc "$@")|$(linear out/newton.ngc "$@")" |
    awk -F'|' '{ printf "%-38s %8.1f %8.1f    about %2d %%\n", $1, $2, $3, 5 * int(20 * (1 - $3 / $2) + 0.5) }'
}
cat machine.toml drift.toml >out/drifting.toml

echo
echo "--- Total linear error (mean of 100 points, um)"
echo "after one differential step: $(linear out/one_step.ngc machine.toml | awk '{ printf "%.1f", $1 }')"
echo "                                         before    after   less by"
row "21 errors" machine.toml
row "  and noise of 1.2 um" machine.toml --noise-um 1.2
row "  and wear of 0.05 um per metre" machine.toml --wear-um-per-m 0.05
row "  and wear of 0.2 um per metre" machine.toml --wear-um-per-m 0.2
row "  and thermal drift" out/drifting.toml --clock --time-step-s 20
row "  and drift, noise, wear of 0.2" out/drifting.toml --clock --time-step-s 20 --noise-um 1.2 --wear-um-per-m 0.2

echo
echo "--- The part after compensation, with all of it, touched by a probe of 0.5 um standard uncertainty"
"$abbe" machine out/drifting.toml out/newton.ngc $place --surface bowl.toml --clock --time-step-s 20 --noise-um 1.2 --wear-um-per-m 0.2 -o out/after.csv >out/after.txt
"$abbe" inspect bowl.toml out/after.csv --probe-um 0.5 --svg out/after.svg | tell "rms|profile|linear"

#!/bin/sh
# One differential step, and when it is not enough.
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

position=X=120.5,Y=-85.25,Z=-40.75

echo "--- The deviation"
"$abbe" predict machine.toml --at $position

echo
echo "--- One step: dq = J^+ D, error and Jacobian from the same adjoints, first order"
"$abbe" correct machine.toml --at $position --method one-step
echo
echo "--- Iterated, errors at the corrected commands"
"$abbe" correct machine.toml --at $position --method newton

echo
echo "--- Over the travels, and on the same machine with errors ten times as large (errors_ten_times.toml)"
for errors in errors.toml errors_ten_times.toml; do
  for method in one-step newton closed-form; do
    printf '%-22s %-12s' $errors $method
    "$abbe" correct machine.toml --errors $errors --points grid.csv --method $method | tail -n 1
    "$abbe" correct machine.toml --errors $errors --points grid.csv --method $method --json > out/$method-$errors.json
  done
done

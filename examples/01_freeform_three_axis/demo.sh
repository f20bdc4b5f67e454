#!/bin/sh
# What a machine's errors do to a part, and what is left of them after compensation.
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

# G54: where the part's zero stands in machine coordinates, as probed on the machine.
"$abbe" compensate machine.toml freeform.ngc -o out/freeform.ngc \
  --offset G54=X130,Y60,Z-190 --tools tools.tbl \
  --report out/report.json --figure out/figure.svg

cat <<'TEXT'

Before compensation the tip was up to 29 um from where the program wants it, most of it in Y at the right
end of the part; what is left is below 1 um. Look at
  out/figure.svg    before and after, on the part and along the path
  out/freeform.ngc  the program to run; abbe diff freeform.ngc out/freeform.ngc lists every change
  out/report.json   every number
TEXT

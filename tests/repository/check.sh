#!/usr/bin/env bash
# Facts about the tree that reviews should not have to look for.   check.sh ROOT
#   a source file is a room: at most 640 lines
#   no open ends: words that promise to come back later
#   no paths of the machine it was written on
#   scripts that start with #! may be executed
set -uo pipefail
cd "$1" || exit 1
kMaxLines=640
# Bracketed, so that this file does not match itself.
open_ends='FIX[M]E|TO[D]O|(^|[^X])X[X]X([^X]|$)'  # mkstemp needs six of them
machine_paths='/wor[k]/|/far[m]/|\.librar[y]|/hom[e]/[a-z]'
complaints=0
complain() { printf '%s\n' "$1"; complaints=$((complaints + 1)); }

list_files() {
  if [ -e .git ]; then
    git ls-files -z --cached --others --exclude-standard
  else
    find . -path ./build -prune -o -type f -print0
  fi
}

while IFS= read -r -d '' file; do
  file=${file#./}
  [ -f "$file" ] || continue
  case "$file" in
    *.cpp | *.h | *.sh | *.cmake)
      lines=$(wc -l <"$file")
      [ "$lines" -le $kMaxLines ] || complain "$file: $lines lines, more than $kMaxLines"
      ;;
  esac
  case "$file" in
    *.sh | run | .ci/run) [ -x "$file" ] || complain "$file: a script that may not be executed" ;;
  esac
  case "$file" in
    LICENSE | CHANGELOG.md | */corpus/*) continue ;;
  esac
  while IFS= read -r line; do
    complain "$file:$line"
  done < <(grep -nIE "$open_ends|$machine_paths" "$file")
done < <(list_files)

[ $complaints = 0 ] || { printf '%d complaints\n' $complaints; exit 1; }

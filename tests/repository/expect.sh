#!/usr/bin/env bash
# The test of the test: check.sh must name every fault of a tree made for it.   expect.sh CHECK FOLDER
set -euo pipefail
check=$1 tree=$2
rm -rf "$tree"
mkdir -p "$tree/abbe" "$tree/corpus"
seq 641 | sed 's|^|// |' >"$tree/abbe/hall.cpp"
seq 640 | sed 's|^|// |' >"$tree/abbe/room.cpp"
printf '// TO%s: later\nint x;\n' DO >"$tree/abbe/later.h"
printf 'see /wor%s/notes\n' k/me >"$tree/notes.md"
printf '#!/bin/sh\n' >"$tree/go.sh"
text=$("$check" "$tree") && { echo "a tree full of faults was accepted"; exit 1; }
for wanted in 'abbe/hall.cpp: 641 lines' 'abbe/later.h:1:' 'notes.md:1:' 'go.sh: a script' '4 complaints'; do
  grep -qF "$wanted" <<<"$text" || { printf 'not reported: %s\nreported:\n%s\n' "$wanted" "$text"; exit 1; }
done
rm -rf "$tree"

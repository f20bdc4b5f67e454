"""Recorded captures, kept beside the repository: every datagram as tshark reads it."""
import pathlib
import sys

import common

abbe, source = sys.argv[1:3]
common.need("tshark")
folder = pathlib.Path(source).parent / "shared" / "data" / "ethercat"
captures = sorted(folder.glob("*.pcapng")) + sorted(folder.glob("*.cap"))
if not captures:
    print("no ../shared/data/ethercat: skipped")
    sys.exit(common.SKIPPED)
for path in captures:
    print(f"{path.name}: {common.compare(abbe, path)} datagrams are equal")

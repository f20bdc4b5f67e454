"""Synthetic captures of `abbe simulate capture`, judged by tshark: it finds nothing malformed, reads the same datagrams,
and its bytes are the columns. Converted to pcapng (libpcap's reader) the columns stay the same."""
import csv
import math
import pathlib
import shutil
import sys
import tempfile

import common

abbe, source = sys.argv[1:3]
common.need("tshark")
AXES = ["--axis", "X=1001:10000/mm,C=1002:-3600/deg"]
ROWS = 400
# Where servo_map of two axes puts them: bytes behind the first logical address.
PLACES = {"X.position_actual_mm": (14, 1 / 10000), "C.position_actual_deg": (28, -1 / 3600)}


def decoded(path, *more):
    with open(path.with_suffix(".csv"), "w") as out:
        out.write(common.run(abbe, "capture", str(path), *AXES, *more))
    with open(path.with_suffix(".csv")) as file:
        return list(csv.DictReader(file))


def check_columns(path, rows):
    back = [p["ecat.data"][-1].replace(":", "") for p in common.of_tshark(path).values()
            if p["ecat.cmd"][-1] in ("12", "0x0c") and p["ecat.cnt"][-1] != "0"]
    if len(back) != ROWS or len(rows) != ROWS:
        sys.exit(f"{path}: {len(back)} cycles by tshark, {len(rows)} by abbe, {ROWS} written")
    for row, text in zip(rows, back):
        data = bytes.fromhex(text)
        for name, (place, scale) in PLACES.items():
            raw = int.from_bytes(data[place:place + 4], "little", signed=True)
            if abs(raw * scale - float(row[name])) > 1e-9:
                sys.exit(f"{path}: {name}: tshark {raw * scale}, abbe {row[name]}")


with tempfile.TemporaryDirectory() as scratch:
    folder = pathlib.Path(scratch)
    signals = folder / "signals.csv"
    with open(signals, "w") as out:
        out.write("t_s,X.position_actual_mm,C.position_actual_deg,X.target_position_mm\n")
        for i in range(ROWS):
            angle = 2 * math.pi * i / ROWS
            out.write(f"{i / 1000},{100 * math.cos(angle):.5f},{-30 * math.sin(angle):.5f},{100 * math.cos(angle)}\n")
    for esl in ("trailer", "header", "none"):
        path = folder / f"{esl}.pcap"
        common.run(abbe, "simulate", "capture", "--signals", str(signals), *AXES, "--esl", esl, "-o", str(path))
        count = common.compare(abbe, path)
        complaints = common.run("tshark", "-n", "-r", str(path), "--enable-heuristic", "esl_eth", "-Y",
                                "_ws.malformed || _ws.expert.severity >= 6291456")
        if complaints:
            sys.exit(f"{path.name}: tshark complains:\n{complaints}")
        rows = decoded(path)
        check_columns(path, rows)
        if shutil.which("editcap"):
            other = folder / f"{esl}_ng.pcapng"
            common.run("editcap", "-F", "pcapng", str(path), str(other))
            if decoded(other) != rows:
                sys.exit(f"{esl}: the pcapng file gives other columns")
        print(f"{esl}: {count} datagrams and {ROWS} rows are equal")
    eni = pathlib.Path(source).parent / "shared" / "data" / "ethercat" / "eni-4-elmo-drives.xml"
    if eni.exists():
        with open(signals, "w") as out:
            out.write("1002.position_actual,1005.target_velocity,1001.2065:00\n")
            for i in range(ROWS):
                out.write(f"{i * 1000 - 7},{-i},{i % 100}\n")
        path = folder / "eni.pcap"
        common.run(abbe, "simulate", "capture", "--signals", str(signals), "--eni", str(eni), "-o", str(path))
        print(f"machine of an ENI file: {common.compare(abbe, path)} datagrams are equal")

"""What abbe and tshark say of the same capture."""
import csv
import io
import shutil
import subprocess
import sys

SKIPPED = 77
FIELDS = ["frame.number", "frame.time_epoch", "esl.port", "esl.timestamp", "ecat.cmd", "ecat.idx", "ecat.adp",
          "ecat.ado", "ecat.lad", "ecat.subframe.length", "ecat.cnt", "ecat.data"]


def need(program):
    if shutil.which(program) is None:
        print(f"{program} is not installed: skipped")
        sys.exit(SKIPPED)


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: exit {done.returncode}\n{done.stderr}")
    return done.stdout


def of_tshark(path):
    """Packet number -> {field: list of its values} of packets with datagrams."""
    arguments = ["tshark", "-n", "-r", str(path), "--enable-heuristic", "esl_eth", "-Y", "ecat", "-T", "fields",
                 "-E", "occurrence=a", "-E", "aggregator=,", "-E", "separator=|"]
    for field in FIELDS:
        arguments += ["-e", field]
    packets = {}
    for line in run(*arguments).splitlines():
        values = dict(zip(FIELDS, line.split("|")))
        packets[int(values["frame.number"])] = {k: v.split(",") if v else [] for k, v in values.items()}
    return packets


def of_abbe(abbe, path):
    """The same of `abbe capture --datagrams`."""
    packets = {}
    for row in csv.DictReader(io.StringIO(run(abbe, "capture", str(path), "--datagrams"))):
        packets.setdefault(int(row["packet"]), []).append(row)
    return packets


def numbers(texts):
    return [int(text, 0) for text in texts]


def compare(abbe, path):
    """How many datagrams were compared; the first difference ends the program."""
    theirs, ours = of_tshark(path), of_abbe(abbe, path)
    if theirs.keys() != ours.keys():
        sys.exit(f"{path}: datagrams in other packets: {sorted(theirs.keys() ^ ours.keys())[:5]}")
    count = 0
    for number, t in theirs.items():
        rows = ours[number]
        logical = [r for r in rows if r["lad"]]
        device = [r for r in rows if not r["lad"]]
        pairs = [
            ("time", [rows[0]["time_s"]], t["frame.time_epoch"]),
            ("command", [int(r["command"]) for r in rows], numbers(t["ecat.cmd"])),
            ("index", [int(r["index"]) for r in rows], numbers(t["ecat.idx"])),
            ("station", [int(r["adp"]) for r in device], numbers(t["ecat.adp"])),
            ("offset", [int(r["ado"]) for r in device], numbers(t["ecat.ado"])),
            ("address", [int(r["lad"]) for r in logical], numbers(t["ecat.lad"])),
            ("length", [int(r["bytes"]) for r in rows], numbers(t["ecat.subframe.length"])),
            ("working counter", [int(r["wkc"]) for r in rows], numbers(t["ecat.cnt"])),
            ("port", [int(r["esl_port"]) for r in rows[:1] if r["esl_port"]], numbers(t["esl.port"])),
            ("switch link", [int(r["esl_ns"]) for r in rows[:1] if r["esl_ns"]], numbers(t["esl.timestamp"])),
        ]
        for what, a, b in pairs:
            if a != b:
                sys.exit(f"{path}: packet {number}: {what}: abbe {a}, tshark {b}")
        # Process data are printed as they are. Of registers and mailboxes tshark prints meanings, and of their bytes
        # only those without one: a part of ours.
        printed = [text.replace(":", "") for text in t["ecat.data"]]
        for row in logical:
            if row["data"] not in printed:
                sys.exit(f"{path}: packet {number}: process data {row['data']}, tshark {printed}")
        data = iter(r["data"] for r in rows)
        for text in printed:
            if not any(text in ours_here for ours_here in data):
                sys.exit(f"{path}: packet {number}: data {text} is not ours")
        count += len(rows)
    return count

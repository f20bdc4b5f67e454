"""Every collected program through abbe: byte for byte the same without errors, compensated and verified on random
machines, or refused with a reason.

    corpus.py ABBE SOURCE --write     makes docs/corpus.md anew (all programs, three machines each)
    corpus.py ABBE SOURCE             compares the short programs, on one machine each, with docs/corpus.md

Ends with 77 (skipped) where the programs are not beside the repository.
"""
import argparse
import json
import pathlib
import random
import re
import subprocess
import sys
import tempfile

SKIPPED = 77
SHORT = 2500  # lines
BY_HAND = "## Random programs\n"  # from here on docs/corpus.md is written by people
STATED = ["--units", "mm", "--integer-words", "units"]
KEEPS = ["--tool-change", "keeps"]
INTO = {".ngc", ".nc", ".gcode", ".gc", ".NC", ".EIA", ".h", ".ptp", ".txt", ".MPF", ".apt"}

# program: for which controls and machines it is read, with which options. What is not named here is read as LinuxCNC's,
# on three axes. "XYZ/4": three axes, a quarter of the errors (what a control does by itself allows no more).
MAESTRO = [("fanuc", "XYZ", STATED), ("haas", "XYZ", STATED)]
HOW = {
    "gcode/maestro-G17_18_19.NC": MAESTRO,
    "gcode/maestro-G81.NC": MAESTRO,
    "gcode/maestro-TEST_G91.NC": MAESTRO,
    "gcode/maestro-VINT_360arc.NC": MAESTRO,
    "gcode/gcws-FANUC0M.nc": [("fanuc", "XYZ", STATED)],
    "gcode/nx-makino-v33.ptp": [("fanuc", "XYZ", [])],
    "gcode/nx-nmv5000-fanuc-G43.4.ptp": [("fanuc", "XYZBC", [])],
    "gcode/nx-haas-vf2tr-noTCP.ptp": [("haas", "XYZAC axis", [])],
    "gcode/nx-dmu70evo-840d-TRAORI.ptp": [("siemens", "XYZBC", [])],
    "gcode/sinu-CAM_TEST.MPF": [("siemens", "XYZAC axis", [])],
    "gcode/gcws-SINUMERIK840D.nc": [("siemens", "XYZBC axis", [])],
    "gcode/camotics-slant_test.nc": [("grbl", "XYZ", []), ("grblhal", "XYZ", []), ("linuxcnc", "XYZ", [])],
    "gcode/cncjs-arc-xy-plane.gcode": [("grbl", "XYZ", []), ("grblhal", "XYZ", []), ("linuxcnc", "XYZ", [])],
    "gcode/cncjs-arc-xz-plane.gcode": [("grbl", "XYZ", []), ("linuxcnc", "XYZ", [])],
    "gcode/cncjs-helical-thread-milling.gcode": [("grbl", "XYZ", [])],
    "gcode/ugs-comments.gcode": [("grbl", "XYZ", [])],
    "gcode/ugs-g17-g18-g19.gcode": [("grbl", "XYZ", []), ("grblhal", "XYZ", []), ("linuxcnc", "XYZ", [])],
    "gcode/5x-boat-xyzac.ngc": [("linuxcnc", "XYZAC", KEEPS)],
    "gcode/5x-boat-xyzbc.ngc": [("linuxcnc", "XYZBC", KEEPS)],
    "gcode/5x-bridgemill-5axisgui.ngc": [("linuxcnc", "XYZBC", [])],
    "gcode/5x-helix_ac.ngc": [("linuxcnc", "XYZAC", [])],
    "gcode/abc_tangent.ngc": [("linuxcnc", "XYZAC axis", [])],
    "gcode/camotics-cameo.nc": [("linuxcnc", "XYZ", KEEPS)],
    "gcode/camotics-wave.gcode": [("linuxcnc", "XYZ", KEEPS)],
    "gcode/lcnc-interp-g81-g17-g98/g17-g98-g81.ngc": [("linuxcnc", "XYZ/32", [])],
    "gcode/lcnc-interp-g81-g17-g99/g17-g99-g81.ngc": [("linuxcnc", "XYZ/32", [])],
    "gcode/lcnc-interp-g84-g17-g98/g17-g98-g84.ngc": [("linuxcnc", "XYZ/32", [])],
    "gcode/nx-mikron-wf21d-heidenhain.ptp": [("iso", "XYZ", [])],
    "gcode/nx-dmc160u-millplus.ptp": [("iso", "XYZ", [])],
    "gcode/nx-okuma-7000m.txt": [("iso", "XYZ", [])],
    "gcode/gcws-FLANGE.nc": [("iso", "XYZ", [])],
    "gcode/gcws-PHILIPS.nc": [("iso", "XYZ", [])],
    "gcode/gpr-mazak.EIA": [("fanuc", "XYZ", STATED)],
    "cldata/manufacture3-top.apt": [("cl", "XYZ", [])],
    "cldata/RotateThick.apt": [("cl", "XYZ/4", [])],
    "cldata/Top-light-cover/Top-light-cover.apt": [("cl", "XYZ/4", [])],
    "cldata/Top-light-cover/expected/11.h": [("heidenhain", "XYZ/4", [])],
    "cldata/Teste-Metrologia/Teste-Metrologia.apt": [("cl", "XYZBC/4", [])],
    "cldata/shimemcunha/shimemcunha.apt": [("cl", "XYZBC/4", [])],
}
USUAL = [("linuxcnc", "XYZ", [])]
KLARTEXT = [("heidenhain", "XYZ", [])]
CHAINS = {
    "XYZ": "w b X Y Z t",
    "XYZAC": "w C A b X Y Z t",
    "XYZBC": "w C B b X Y Z t",
}
ROTARY = {"A": "[-1, 0, 0]", "B": "[0, -1, 0]", "C": "[0, 0, -1]"}


def machine(kind, seed):
    """A machine file. Seed 0: without errors; else errors of every axis, some micrometres and tens of urad per m."""
    chain, _, mode = kind.partition(" ")
    chain, _, part = chain.partition("/")
    text = f'format = 1\n[machine]\nname = "corpus {seed}"\nchain = "{CHAINS[chain]}"\n'
    for axis in chain[3:]:
        text += f"[axis.{axis}]\ndirection = {ROTARY[axis]}\n" + ('errors_seen = "body"\n' if seed else "")
    if len(chain) > 3:
        text += f'[control]\nmode = "{mode or "tcp"}"\n'
        if not mode:
            text += 'codes = { M428 = "tcp", M429 = "axis", "G43.4" = "tcp", G49 = "axis" }\n'
    text += "[errors]\n"
    if seed == 0:
        return text
    draw = random.Random(seed)
    for axis in "XYZ":
        for direction in "XYZABC":
            size = (20 if direction in "XYZ" else 30) / int(part or 1)
            slope, bend = draw.uniform(-size, size) / 500, draw.uniform(-size, size) / 500**2 / 4
            straight = direction in "XYZ" and direction != axis
            text += f"E{direction}{axis} = {{ poly = [0, {0 if straight else slope:.9g}, {bend:.9g}] }}\n"
    for name, size in {"EC0Y": 60, "EB0Z": 60, "EA0Z": 60}.items():
        text += f"{name} = {draw.uniform(-size, size) / int(part or 1):.6g}\n"
    for axis in chain[3:]:
        for direction in "XYZABC":
            if direction == axis:
                continue
            text += f"E{direction}{axis} = {{ sine = [{draw.uniform(-10, 10):.6g}, 0.0174532925, {draw.uniform(-3, 3):.6g}] }}\n"
    return text


def ways(program):
    """For which controls and machines a program is read."""
    return HOW.get(program, KLARTEXT if program.endswith(".h") else USUAL)


def write_tools(folder, program):
    """100 mm long and 10 mm thick, or what a conversational program states (TOOL DEF 5 L+10 R+3)."""
    text = program.read_text("latin-1") if program.suffix == ".h" else ""
    length = dict(re.findall(r"TOOL DEF (\d+) L([+-]?[\d.]+)", text))
    radius = dict(re.findall(r"TOOL DEF (\d+)[^\n]* R([+-]?[\d.]+)", text))
    lines = (f"T{n} P{n} Z{float(length.get(str(n), 100))} D{2 * float(radius.get(str(n), 5))} ; gauge=100\n"
             for n in range(1, 200))
    (folder / "tool.tbl").write_text("".join(lines))


def command_of(way, abbe, folder, machine_file, program, output):
    control, _, options = way
    command = [abbe, "compensate", machine_file, program, "-o", output, "--header", "none", "--json", "--dialect", control]
    if control == "cl":
        return command + ["--offset", "G54=X0,Y0,Z0"] + options
    for offset in ["G54", "G55", "G56", "G57"] + (["G58", "G59"] if control != "siemens" else []):
        command += ["--offset", f"{offset}=X0,Y0,Z0"]
    return command + ["--tools", folder / "tool.tbl", "--start", "X0,Y0,Z0", "--block-delete", "off"] + options


def reason_of(errors):
    """The first finding of a refusal: its code and its line."""
    found = re.search(r":(\d+):\d+: error\[([A-Z]-[A-Z0-9]+)\]: ([^\n]*)", errors)
    found = found or re.search(r"()error\[([A-Z]-[A-Z0-9]+)\]: ([^\n]*)", errors)
    if not found:
        sys.exit(f"no reason in:\n{errors}")
    line, code, message = found.groups()
    others = sorted(set(re.findall(r"error\[([A-Z]-[A-Z0-9]+)\]", errors)) - {code})
    return code, f"line {line}: {message}" if line else message, others


def judge(name, way, abbe, program, folder, seeds):
    """{"accepted": .., ...} of one program, read in one way."""
    before = after = allowed = 0.0
    for seed in [0, *seeds]:
        machine_file, output = folder / "m.toml", folder / "out"
        machine_file.write_text(machine(way[1], seed))
        output.unlink(missing_ok=True)
        run = subprocess.run([str(x) for x in command_of(way, abbe, folder, machine_file, program, output)], capture_output=True, timeout=600)
        errors = run.stderr.decode("utf-8", "replace")
        if run.returncode not in (0, 3, 5):
            sys.exit(f"{name}, machine {seed}: exit {run.returncode}\n{errors}")
        if run.returncode != 0:
            if output.exists():
                sys.exit(f"{name}: refused, and yet written")
            code, reason, others = reason_of(errors)
            return {"accepted": False, "code": code, "reason": reason, "others": others}
        if seed == 0:
            if output.read_bytes() != program.read_bytes():
                sys.exit(f"{name}: bytes change without errors")
            continue
        report = json.loads(run.stdout)
        limit = 1 + report["quantisation_um"]
        if not report["after"]["max_um"] <= limit:
            sys.exit(f"{name}, machine {seed}: {report['after']['max_um']} um are left, {limit} are allowed")
        before = max(before, report["before"]["max_um"])
        after, allowed = max((after, allowed), (report["after"]["max_um"], limit))
    return {"accepted": True, "before": before, "after": after, "allowed": allowed}


def cell(text):
    return "`" + text.replace("|", "/").replace("`", "'") + "`"


def table(programs, answers, seeds):
    accepted = [key for key in answers if answers[key]["accepted"]]
    refused = [key for key in answers if not answers[key]["accepted"]]
    kind = {(n, way[0]): way[1] for n in programs for way in ways(n)}
    text = f"""# Corpus

Made by `tests/corpus/corpus.py ABBE SOURCE --write`. Every program collected from others ({len(programs)}, some of them for several controls; none of them was written for
Abbe, none is part of the repository) has one of two fates:

- **Accepted** ({len(accepted)}): on a machine without errors it comes out byte for byte as it went in; on {len(seeds)} machines with random errors it is
  compensated, verified and within the tolerance of 1 um plus what its digits cost. Micrometres: the largest deviation of the
  tool on any of these machines, before and after, and what was allowed there.
- **Refused** ({len(refused)}): nothing is written; the first reason and its line, then the codes of all other findings.

A test repeats the programs of up to {SHORT} lines on one machine, and fails when a fate or the code of a first reason changes. Every program is given
work offsets at zero, a tool table with 100 mm for every tool (or what TOOL DEF says), and the start X0 Y0 Z0. The machine: its axes; behind `/` the part of
the usual errors (tens of micrometres and of urad per half metre) that cycles allow, inside which nothing can be corrected.

## Accepted

| program | lines | control | machine | before | after | allowed |
|---|---|---|---|---|---|---|
"""
    lines = lambda name: programs[name].read_bytes().count(10)
    for name, control in accepted:
        a = answers[name, control]
        text += f"| `{name}` | {lines(name)} | {control} | {kind[name, control]} | {a['before']:.3g} | {a['after']:.2g} | {a['allowed']:.3g} |\n"
    text += "\n## Refused\n\n| program | lines | control | first reason | | others |\n|---|---|---|---|---|---|\n"
    for name, control in refused:
        a = answers[name, control]
        text += f"| `{name}` | {lines(name)} | {control} | {a['code']} | {cell(a['reason'])} | {' '.join(a['others'])} |\n"
    text += "\n## What each control must accept\n\nNo program of this list may be refused: refusing is no way out.\n\n| control | programs |\n|---|---|\n"
    for each in sorted({control for _, control in answers}):
        names = [f"`{name.split('/', 1)[1]}`" for name, control in accepted if control == each]
        text += f"| {each} | {', '.join(names) or 'none of those collected is within what it reads'} |\n"
    return text


def fates(text):
    """Accepted or the first code, by program and control, as the document has it."""
    rows = re.findall(r"^\| `([^`]+)` \| \d+ \| ([^|]+) \| ([^|]+) \|", text, re.M)
    return {(name, control): (what if what.startswith("E-") else "accepted") for name, control, what in rows}


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("abbe")
    arguments.add_argument("source", type=pathlib.Path)
    arguments.add_argument("--write", action="store_true")
    a = arguments.parse_args()
    data = a.source.parent / "shared" / "data"
    found = [p for top in ("gcode", "cldata") for p in sorted((data / top).rglob("*")) if p.suffix in INTO and ("expected" not in p.parts or p.suffix == ".h")]
    if not found:
        print(f"no {data}: skipped")
        sys.exit(SKIPPED)
    programs = {str(p.relative_to(data)): p for p in found}
    document = a.source / "docs" / "corpus.md"
    seeds = [1, 2, 3] if a.write else [1]
    answers = {}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for key, program in programs.items():
            if a.write or program.read_bytes().count(10) <= SHORT:
                write_tools(folder, program)
                for way in ways(key):
                    answers[key, way[0]] = judge(key, way, a.abbe, program, folder, seeds)
    if a.write:
        kept = document.read_text().partition(BY_HAND)[2] if document.exists() else "\n"
        document.write_text(table(programs, answers, seeds) + "\n" + BY_HAND + kept)
    known = fates(document.read_text())
    wrong = [f"{n[0]}, {n[1]}: {known.get(n)} in docs/corpus.md, now {'accepted' if v['accepted'] else v['code']}" for n, v in answers.items()
             if known.get(n) != ("accepted" if v["accepted"] else v["code"])]
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"{len(answers)} ways to read {len({name for name, _ in answers})} programs, {sum(v['accepted'] for v in answers.values())} accepted")


if __name__ == "__main__":
    main()

"""check_numbers.py ABBE: what `derive` prints, evaluated by sympy, is what `predict` computes, and the
levers of --contributions times the errors add up to it."""

import random
import sys
import tomllib

from common import HERE, reader_of, run, sympy

RELATIVE = 1e-10
POINTS = 1


def values_of(machine):
    """The machine's errors, all of them constants, exactly in mm and rad."""
    text = tomllib.loads(machine.read_text(), parse_float=sympy.Rational)
    units = text.get("units", {})
    length = 1 if units.get("error_length") == "mm" else sympy.Rational(1, 1000)
    angle = 1 if units.get("error_angle") == "rad" else sympy.Rational(1, 10**6)
    return {name: value * (angle if name[1] in "ABC" else length) for name, value in text["errors"].items()}


def check(program, machine, generator):
    values = values_of(machine)
    answer = run(program, "derive", machine, "--json", "--contributions")
    assert set(answer["errors"]) == set(values), machine
    read = reader_of(answer)
    failures = 0
    for _ in range(POINTS):
        at = {axis: generator.randint(-80, 80) for axis in answer["axes"]}
        length = sympy.Rational(254, 10) if '"in"' in machine.read_text() else sympy.Integer(1)
        positions = {axis: number * (sympy.pi / 180 if axis[0] in "ABC" else length) for axis, number in at.items()}
        numbers = {sympy.Symbol(k): v for k, v in {**values, **positions}.items()}
        point = run(program, "predict", machine, "--model", "first-order", "--json",
                    "--at", ",".join(f"{axis}={number}" for axis, number in at.items()))["points"][0]
        predicted = {"deviation": dict(zip("xyz", point["deviation"]["position_mm"])),
                     "tool_axis": dict(zip("xyz", point["deviation"]["tool_axis"])),
                     "tool_twist": dict(zip(("dx", "dy", "dz", "ex", "ey", "ez"),
                                            point["tool_twist"]["translation_mm"] + point["tool_twist"]["rotation_rad"]))}
        for member, components in predicted.items():
            for key, number in components.items():
                evaluated = float(sympy.N(read(answer[member][key]).subs(numbers), 30))
                levers = sum(values[c["error"]] * read(c[member][key]).subs(positions)
                             for c in answer["contributions"])
                for what, value in (("equation", evaluated), ("levers", float(sympy.N(levers, 30)))):
                    # Of the errors' own size, or of what they cancel to.
                    if abs(value - number) > RELATIVE * max(abs(number), 0.01 if key[0] != "e" else 1e-5):
                        failures += 1
                        print(f"{machine.name} {member}.{key} at {at}: {what} {value}, predicted {number}")
    return failures


if __name__ == "__main__":
    random_numbers = random.Random(1)
    machines = sorted((HERE / "machines").glob("*.toml"))
    found = sum(check(sys.argv[1], machine, random_numbers) for machine in machines)
    print(f"{len(machines)} machines, {found} differences")
    sys.exit(1 if found or not machines else 0)

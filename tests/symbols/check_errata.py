"""check_errata.py [--print]: the consequences that docs/errata.md states, calculated again: the printed
and the corrected form of a formula at the position and with the errors of the test machines."""

import math
import sys
import tomllib

from common import HERE, sympy
import published

S, pi = sympy.Symbol, sympy.pi
ERRATA = HERE.parents[1] / "docs" / "errata.md"

POSITIONS = {
    "seed_000": {"X": -420.5, "Y": 350.25, "Z": 180.75, "Z1": 60.125, "A": 12 * pi / 180, "B": -25 * pi / 180,
                 "B1": 30 * pi / 180},
    "seed_001_after": {"X": 120.5, "Y": -85.25, "Z": -40.75},
    "seed_002": {"X": -650.25, "Z": 310.5, "C": 37.5 * pi / 180},
    "seed_003": {"X": -55.5, "Y": 20.25, "Z": -30.125, "A": 0.5, "C": -1.2},
}


def values(machine):
    errors = tomllib.loads((HERE / "machines" / f"{machine}.toml").read_text())["errors"]
    return {S(name): value for name, value in {**errors, **POSITIONS[machine]}.items()}


def numbers(machine, *expressions):
    known = values(machine)
    return [float(n) for n in sympy.lambdify(list(known), expressions, "math")(*map(float, known.values()))]


def um(*components):
    """A vector in um, as it stands in the table."""
    texts = [f"{1000 * c + 0.0:.2f}" for c in components]
    return texts[0] if len(texts) == 1 else "(" + ", ".join(texts) + ")"


def length_of(components):
    return sum(c * c for c in components) ** 0.5


def seed_000():
    machine = "seed_000"
    correct = list(published.seed_000()["deviation"].values())
    at = numbers(machine, *correct)

    def change(**names):
        other = [e.subs({S(k): v for k, v in names.items()}, simultaneous=True) for e in correct]
        return [b - a for a, b in zip(at, numbers(machine, *other))]

    yield "000-array", um(length_of(at))
    lost = {f"T{d}Z1": 0 for d in "XYZ"}
    yield "000-13-drift", um(length_of(change(**lost)))
    z, z1, squareness = numbers(machine, S("Z"), S("Z1"), S("EA0Z1"))
    yield "000-13-squareness", um(abs((z - z1) * squareness))
    yield "000-13-z", f"{abs(z - z1):.1f} mm"
    twice = {f"T{d}{axis}": S(f"E{d}{axis}") for d in "XYZ" for axis in ("A", "B", "B1")}
    yield "000-third-matrix", um(*change(**twice))
    yield "000-parallelism", um(*change(EB0A=S("EC0A"), EC0A=S("EB0A")))
    turned = numbers(machine, *published.seed_000(length=-150)["deviation"].values())
    yield "000-tool", um(*(b - a for a, b in zip(at, turned)))


def seed_001():
    machine = "seed_001_after"
    forms = {name: numbers(machine, *published.seed_001(name)["deviation"].values())
             for name in ("after", "frame", "line")}
    yield "001-squareness", um(*(p - c for p, c in zip(forms["after"], forms["line"])))
    x = forms["after"][0]
    yield "001-column", f"{um(x)} um becomes {um(2 * x)} um"


def seed_002():
    machine = "seed_002"
    x, z, r = S("X"), S("Z"), S("C")
    c, s = sympy.cos(r), sympy.sin(r)
    a, b = S("EAC") + S("TAC"), S("EBC") + S("TBC")
    drift, = numbers(machine, S("TXZ") - S("TYZ"))
    roll, = numbers(machine, 2 * z * S("EAX"))
    yield "002-14-drift", um(drift)
    yield "002-14-roll", um(roll)
    yield "002-14", um(drift + roll)
    yield "002-15", um(*numbers(machine, x * (c * a + s * b) - x * (s * a + c * b)))
    yield "002-20", um(*numbers(machine, -x * S("EAX") + z * S("EAX")))
    # What a parked tool adds to (25) to (27).
    yield "002-25", um(*numbers(machine, -z * (c * b + s * a), -x * S("ECC") + z * (c * a - s * b), x * (s * a + c * b)))


def seed_003():
    machine = "seed_003"
    m = published.LETTERS_003
    tilt = m.aA + m.aT + m.aY + m.aZY + m.aZ - m.aX - m.aCY
    i, j = -sympy.sin(S("C")) * sympy.sin(S("A")), -sympy.cos(S("C")) * sympy.sin(S("A"))
    a, b = m.aC + m.aW, m.bC + m.bW
    step = (b * i - a * j) / sympy.sin(S("A")) - tilt
    missing, = numbers(machine, step)
    yield "003-a", f"{abs(missing) * 1e6:.1f} urad"
    yield "003-a-um", um(abs(missing) * 200)
    # Without fraction bar and root the argument is a sum in which j^2 stands alone.
    n = m.bT + m.bA - m.bAZ
    tilts = m.bCX - m.bAZ + m.bX - m.bY - m.bZX - m.bZ
    cos_a = sympy.cos(S("A"))
    literal = sympy.asin(n - tilts * cos_a * i**2 + j**2 - 2 * j * cos_a * a + 2 * i * cos_a * b)
    turn, = numbers(machine, literal - sympy.asin((n - tilts * cos_a) / sympy.sin(S("A"))))
    yield "003-c", f"{abs(turn) * 1e3:.1f} mrad"
    yield "003-c-mm", f"{abs(turn) * 100:.2f} mm"


def seed_004():
    """Delta x of the XOY circle: radius 100 mm, 0.2 rad/s, 48 points from the start point. Coefficients in mm
    of static d = c1 q + c2 q^2 and dynamic m1 sin(w_v t + p_v) + m2 sin(w_a t + p_a), made up."""
    static = {"dyx": (0.0, 0.0), "dxy": (-8.87e-06, 2.51e-09)}  # of x, of y
    dynamic = {"yx": (1.18e-07, 1.35e-07), "xy": (-0.000673, 0.000816), "xx": (0.000607, 0.000828)}
    frequencies = {"x": ((0.37, 0.3), (0.71, -0.4)), "y": ((0.53, 1.1), (0.89, 2.0))}  # (w, p) of v, of a
    wrong_axis = wrong_bracket = 0.0
    for n in range(48):
        angle = 2 * math.pi * n / 48
        t, x, y = angle / 0.2, 100 * (math.cos(angle) - 1), 100 * math.sin(angle)
        moving = {name: sum(c * math.sin(w * t + p) for c, (w, p) in zip(both, frequencies[name[1]]))
                  for name, both in dynamic.items()}
        bracketed = {name: sum(c * (math.sin(w * t) + p) for c, (w, p) in zip(both, frequencies[name[1]]))
                     for name, both in dynamic.items()}
        still = {name: c1 * q + c2 * q * q for (name, (c1, c2)), q in zip(static.items(), (x, y))}
        wrong_axis = max(wrong_axis, abs(still["dyx"] + moving["yx"] - still["dxy"] - moving["xy"]))
        wrong_bracket = max(wrong_bracket, abs(sum(bracketed[k] - moving[k] for k in ("xx", "xy"))))
    yield "004-4", um(wrong_axis)
    yield "004-9", um(wrong_bracket)


if __name__ == "__main__":
    found = [row for seed in (seed_000, seed_001, seed_002, seed_003, seed_004) for row in seed()]
    if "--print" in sys.argv:
        for label, text in found:
            print(f"{label:20} {text}")
        sys.exit(0)
    page = ERRATA.read_text(encoding="utf-8")
    absent = [(label, text) for label, text in found if text not in page]
    for label, text in absent:
        print(f"docs/errata.md does not state {label}: {text}")
    print(f"{len(found)} consequences, {len(absent)} differ")
    sys.exit(1 if absent else 0)

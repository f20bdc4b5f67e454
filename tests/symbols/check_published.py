"""check_published.py ABBE: the derived equations are the corrected ones of published models."""

import sys

from common import HERE, normal_form, reader_of, run, sympy
import published

if __name__ == "__main__":
    program, failures, compared = sys.argv[1], 0, 0
    for case in published.cases():
        answer = run(program, "derive", HERE / "machines" / f"{case['machine']}.toml", "--format", "json")
        read = reader_of(answer)
        derived = {member: {key: read(text) for key, text in answer[member].items()}
                   for member in ("deviation", "tool_axis", "tool_twist")}
        wanted = case["equations"](derived) if callable(case["equations"]) else case["equations"]
        for member, components in wanted.items():
            for key, expected in components.items():
                compared += 1
                difference = case.get("zero", normal_form)(derived[member][key] - expected)
                if difference != 0:
                    failures += 1
                    print(f"{case['origin']}: {member}.{key} differs by\n  {difference}")
    # The comparison itself must see a wrong sign.
    x = sympy.Symbol("EXX") * sympy.sin(sympy.Symbol("A"))
    assert normal_form(x + x) != 0 and normal_form(x - x) == 0
    print(f"{compared} equations compared, {failures} differ")
    sys.exit(1 if failures or not compared else 0)

"""What the tests of `abbe derive` share: running the program, reading its expressions with sympy."""

import json
import subprocess
import sys
from pathlib import Path

SKIPPED = 77
HERE = Path(__file__).parent

try:
    import sympy
    from sympy.parsing.sympy_parser import parse_expr, rationalize, standard_transformations
except ImportError:
    print("skipped: python3-sympy is not installed")
    sys.exit(SKIPPED)


def run(program, *arguments):
    """The JSON answer of a verb. Findings are warnings about the test machine and do not matter."""
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 5):
        sys.exit(f"abbe {' '.join(map(str, arguments))} ended with {done.returncode}:\n{done.stderr}")
    return json.loads(done.stdout)


def reader_of(answer):
    """A function that reads the answer's expressions. A name that is neither an error nor an axis of
    the machine, or anything else than + - * ( ) numbers sin cos, is a mistake."""
    names = {name: sympy.Symbol(name) for name in answer["errors"] + answer["axes"]}
    # parse_expr puts Symbol(), Integer() .. around what it finds and evaluates the result.
    known = {"Integer": sympy.Integer, "Float": sympy.Float, "Rational": sympy.Rational, "sin": sympy.sin,
             "cos": sympy.cos, "__builtins__": {}}

    def read(text):
        rest = text
        for name in sorted([*names, "sin", "cos"], key=len, reverse=True):
            rest = rest.replace(name, "")
        assert set(rest) <= set("0123456789.e+-*() "), f"unexpected characters in {text}"
        assert "**" not in text and "/" not in text, text
        return parse_expr(text, local_dict=names, global_dict=known,
                          transformations=(*standard_transformations, rationalize))

    return read


def normal_form(expression):
    """Expanded, without squares of sines: two expressions that are equal have the same one."""
    expression = sympy.expand(sympy.sympify(expression))
    angles = {f.args[0] for f in expression.atoms(sympy.sin, sympy.cos)}
    for angle in angles:
        sine, cosine = sympy.Dummy("s"), sympy.Dummy("c")
        expression = expression.subs({sympy.sin(angle): sine, sympy.cos(angle): cosine})
        expression = sympy.expand(sympy.rem(expression, sine**2 + cosine**2 - 1, sine))
        expression = expression.subs({sine: sympy.sin(angle), cosine: sympy.cos(angle)})
    return sympy.expand(expression)

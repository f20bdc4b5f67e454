"""The equations of four published models, with the corrections of docs/errata.md, in the papers' letters.

Each case names the machine file with the same chain, and the components of `abbe derive`'s answer that
the equations give. Positions in mm and rad; an equation that is missing here was not published.
"""

from common import sympy

S = sympy.Symbol
sin, cos = sympy.sin, sympy.cos


def named(text):
    """{"dxx": EXX, ..} from "dxx=EXX ..", for papers whose letters are not ours."""
    return {left: S(right) for left, right in (pair.split("=") for pair in text.split())}


class Names(dict):
    """The paper's letters as attributes."""

    __getattr__ = dict.__getitem__


def vector(*components):
    return sympy.Matrix(3, 1, components)


def xyz(v, keys="x y z"):
    return dict(zip(keys.split(), v))


def d_of(axis, error_class="E"):
    return vector(*(S(f"{error_class}{direction}{axis}") for direction in "XYZ"))


def e_of(axis):
    return vector(*(S(f"E{direction}{axis}") for direction in "ABC"))


def about(direction, angle):
    c, s = cos(angle), sin(angle)
    return {"x": sympy.Matrix([[1, 0, 0], [0, c, -s], [0, s, c]]),
            "y": sympy.Matrix([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
            "z": sympy.Matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]])}[direction]


def seed_000(length=150):
    """Equations (28) and (31): first order, errors of installation after the rotation as printed."""
    x, y, z, z1, alpha, beta, beta1 = (S(n) for n in "X Y Z Z1 A B B1".split())
    d1, d2, d3, d4 = 85, 240, 1500, 600
    s_xy, s_xz, s_yz = -S("EC0X"), -S("EB0Z"), S("EA0Z")
    s_xz1, s_yz1 = -S("EB0Z1"), S("EA0Z1")
    q = vector(0, -d1, z1 - d2 + length)
    e_z = vector(0, 0, 1)
    tool = vector(0, 0, length)
    r_a, r_b, r_9 = about("x", alpha), about("y", beta), about("y", beta1)
    u, n = r_a * r_b * q, r_a * r_b * e_z
    install_a = vector(0, S("EB0A"), S("EC0A"))
    install_b = vector(S("EA0B"), 0, S("EC0B"))
    install_b1 = vector(S("EA0B1"), 0, S("EC0B1"))
    d_y = d_of("Y") + d_of("Y", "T")
    d_x = d_of("X") + d_of("X", "T") + vector(0, -x * s_xy, 0)
    d_z = d_of("Z") + d_of("Z", "T") + vector(-z * s_xz, -z * s_yz, 0)
    d_z1 = d_of("Z1") + d_of("Z1", "T") + vector(-z1 * s_xz1, -z1 * s_yz1, 0)
    spindle = vector(S("TAS"), S("TBS"), 0)
    p_w = r_9.T * (u + vector(x, y + d4, z + d3))
    v_w = r_9.T * n
    on_bed = (d_y + e_of("Y").cross(u + vector(x, 0, z)) + d_x + e_of("X").cross(u + vector(0, 0, z))
              + d_z + e_of("Z").cross(u)
              + r_a * (d_of("A") + d_of("A", "T") + (e_of("A") + install_a).cross(r_b * q))
              + r_a * r_b * (d_of("B") + d_of("B", "T") + (e_of("B") + install_b).cross(q))
              + r_a * r_b * (d_z1 + e_of("Z1").cross(tool)) + r_a * r_b * (d_of("S", "T") + spindle.cross(tool)))
    deviation = r_9.T * on_bed - (d_of("B1") + d_of("B1", "T") + (e_of("B1") + install_b1).cross(p_w))
    axis = (r_9.T * ((e_of("Y") + e_of("X") + e_of("Z")).cross(n) + r_a * (e_of("A") + install_a).cross(r_b * e_z)
                     + r_a * r_b * (e_of("B") + install_b + e_of("Z1") + spindle).cross(e_z))
            - (e_of("B1") + install_b1).cross(v_w))
    return {"deviation": xyz(deviation), "tool_axis": xyz(axis)}


LETTERS_001 = Names(named("x=X y=Y z=Z Sxy=EC0X Syz=EA0Z Sxz=EB0Z " + " ".join(
    f"{letter}{i}{axis.lower()}=E{name}{axis}" for axis in "XYZ"
    for letter, i, name in ("dxX", "dyY", "dzZ", "exA", "eyB", "ezC"))))


def seed_001(squareness, tx=0, ty=0, tz=0):
    """Equation (26), with the squareness where `squareness` puts it."""
    m = LETTERS_001
    ex = -m.dxx + m.dxy + m.dxz + m.y * m.ezx - m.z * (m.eyx - m.eyy)
    ey = -m.dyx + m.dyy + m.dyz + m.x * m.ezx + m.z * (m.exx - m.exy)
    ez = -m.dzx + m.dzy + m.dzz - m.y * m.exx - m.x * m.eyx
    if squareness == "after":  # added to the angles, as printed
        about_z = m.Sxy + m.ezx - m.ezy - m.ezz
        about_y = m.Sxz - m.eyx + m.eyy + m.eyz
        about_x = m.Syz - m.exx + m.exy + m.exz
        ex += m.y * m.Sxy + ty * about_z + tz * about_y
        ey += m.x * m.Sxy - tx * about_z - tz * about_x
        ez += -tx * about_y + ty * about_x
        twist = vector(about_x, about_y, -about_z)
        return {"deviation": xyz((ex, ey, ez)), "tool_twist": xyz(twist, "ex ey ez")}
    ex += m.z * m.Sxz
    ey -= m.z * m.Syz
    if squareness == "frame":
        ex += m.y * m.Sxy
    else:
        ey -= m.x * m.Sxy
    return {"deviation": xyz((ex, ey, ez))}


def seed_002():
    """Equations (10) to (15)."""
    x, z, r = S("X"), S("Z"), S("C")
    c, s = cos(r), sin(r)
    tilt_a, tilt_b = S("EAC") + S("TAC"), S("EBC") + S("TBC")
    shift_u, shift_v = S("EXC") + S("TXC"), S("EYC") + S("TYC")

    def moved(direction):  # of column, carriage and spindle
        return sum(S(f"{kind}{direction}{axis}") for kind, axis in ("TS", "EX", "TX", "EZ", "TZ"))

    return {"tool_twist": {
        "ex": S("EAX") + S("EAZ") + S("TAS") + s * tilt_b - c * tilt_a,
        "ey": S("EBX") + S("EBZ") - s * tilt_a - c * tilt_b,
        "ez": S("ECX") + S("ECZ") + S("TCS") - S("ECC"),
        "dx": moved("X") + z * S("EBX") - c * (shift_u + z * tilt_b) + s * (shift_v - z * tilt_a),
        "dy": moved("Y") - x * S("ECC") - z * S("EAX") - c * (shift_v - z * tilt_a) - s * (shift_u + z * tilt_b),
        "dz": moved("Z") - (S("EZC") + S("TZC")) + x * (s * tilt_a + c * tilt_b)}}


LETTERS_003 = Names(named(
    "aCY=EA0C bCX=EB0C gYX=EC0Y aZY=EA0Z bZX=EB0Z gAY=EC0A bAZ=EB0A dAy=EY0A dAz=EZ0A dCx=EX0C dCy=EY0C "
    + " ".join(f"{letter}{axis}=E{name}{ours}" for axis, ours in ("XX", "YY", "ZZ", "AA", "CC", "Tt", "Ww")
               for letter, name in ("aA", "bB", "gC"))
    + " " + " ".join(f"d{axis}{i.lower()}_={'E' + i + ours}" for axis, ours in ("XX", "YY", "ZZ", "AA", "CC", "Tt", "Ww")
                     for i in "XYZ")))


def seed_003_matrices():
    """Equation (1) as a product of matrices, its part of first order in the errors."""
    m = LETTERS_003
    x, y, z, a, c = (S(n) for n in "X Y Z A C".split())
    length = 200

    def rigid(r, p):
        return sympy.Matrix.vstack(sympy.Matrix.hstack(r, p), sympy.Matrix([[0, 0, 0, 1]]))

    def small(d, e):  # the derivative of an error matrix
        skew = sympy.Matrix([[0, -e[2], e[1]], [e[2], 0, -e[0]], [-e[1], e[0], 0]])
        return sympy.Matrix.vstack(sympy.Matrix.hstack(skew, d), sympy.zeros(1, 4))

    one, nothing = sympy.eye(3), vector(0, 0, 0)

    def error(sign, d, e):
        return (sympy.eye(4), sign * small(d, e))

    def motion(r, p):
        return (rigid(r, p), sympy.zeros(4))

    location_a = (vector(0, m.dAy, m.dAz), vector(0, m.bAZ, m.gAY))
    location_c = (vector(m.dCx, m.dCy, 0), vector(m.aCY, m.bCX, 0))
    factors = [error(-1, d_of("w"), e_of("w")), error(-1, d_of("C"), e_of("C")),
               motion(about("z", c).T, nothing), error(-1, *location_c), error(-1, d_of("X"), e_of("X")),
               motion(one, vector(-x, 0, 0)),
               error(1, nothing, vector(0, 0, m.gYX)), motion(one, vector(0, y, 0)), error(1, d_of("Y"), e_of("Y")),
               error(1, nothing, vector(m.aZY, m.bZX, 0)), motion(one, vector(0, 0, z)),
               error(1, d_of("Z"), e_of("Z")),
               motion(one, vector(0, 0, length)), error(1, *location_a), motion(about("x", a), nothing),
               error(1, d_of("A"), e_of("A")), error(-1, *location_a), motion(one, vector(0, 0, -length)),
               error(1, d_of("t"), e_of("t"))]
    nominal, change = sympy.eye(4), sympy.zeros(4)
    for exact, first_order in factors:
        change = change * exact + nominal * first_order
        nominal = nominal * exact
    return {"deviation": xyz(change[:3, 3]), "tool_axis": xyz(change[:3, 2])}


def seed_003_closed_form(derived):
    """The printed inverse C', A', Z', Y', X', with the lost fraction bar, root and A' restored: the
    commands that it returns cancel the derived deviation to first order. Returns what is left of
    each component, as the expected value: derived = -(Jacobian of the ideal machine) * (q' - q)."""
    m = LETTERS_003
    X, Y, Z, A, C = (S(n) for n in "X Y Z A C".split())
    length, t = 200, S("t")
    p = about("z", C).T * (about("x", A) * vector(0, 0, -length) + vector(-X, Y, Z + length))
    v = about("z", C).T * about("x", A) * vector(0, 0, 1)
    errors = {error: t * error for error in m.values()}
    i, j, k, x, y, z = (S(n) for n in ("i_", "j_", "k_", "x_", "y_", "z_"))

    gamma = m.gAY - m.gC - m.gW - m.gX + m.gYX + m.gY + m.gZ
    a, b = m.aC + m.aW, m.bC + m.bW
    p_, q_ = i + gamma * j + b * k, gamma * i - j + a * k
    n_ = m.bT + m.bA - m.bAZ - (m.bCX - m.bAZ + m.bX - m.bY - m.bZX - m.bZ) * k
    c_new = sympy.asin(n_ / sympy.sqrt(i**2 + j**2 - 2 * j * k * a + 2 * i * k * b)) - sympy.atan2(p_, q_)
    a_new = sympy.acos(k - b * i + a * j) - (m.aA + m.aT + m.aY + m.aZY + m.aZ - m.aX - m.aCY)
    cA, sA, cC, sC = cos(S("A'")), sin(S("A'")), cos(S("C'")), sin(S("C'"))
    u1 = m.dWx_ + m.dCx_ + x + b * z - (m.gW + m.gC + m.gX) * y
    u2 = m.dWy_ + m.dCy_ + y - a * z + (m.gW + m.gC + m.gX) * x
    k1 = m.dTy_ - m.dAy + m.dAy_ + (m.aA + m.aY + m.aZY + m.aZ) * length
    z_new = (z + m.dWz_ - m.dAz - length + m.dCz_ + m.dXz_ - m.dYz_ - m.dZz_ + a * y - b * x
             + (m.aCY + m.aX) * (y * cC + x * sC) - (m.bCX + m.bX) * (x * cC - y * sC)
             - k1 * sA + (length + m.dAz - m.dTz_ - m.dAz_) * cA)
    y_new = ((m.dTz_ - m.dAz - length + m.dAz_) * sA + m.dCy - m.dAy + m.dXy_ - m.dYy_ - m.dZy_
             + (m.aY + m.aZY + m.aZ) * length - k1 * cA - (m.aCY + m.aX) * z + u2 * cC + u1 * sC
             + (m.aY + m.aZY) * S("Z'"))
    x_new = (-((m.bAZ + m.bY + m.bZX + m.bZ) * length * cA + m.dCx - m.dTx_ - m.dAx_ + m.dXx_ - m.dYx_ - m.dZx_
               + (m.bA - m.bAZ - m.bY - m.bZX - m.bZ) * length + (m.bCX + m.bX) * z + u1 * cC - u2 * sC
               + (m.gAY + m.gYX + m.gY + m.gZ) * length * sA)
             + (m.bY + m.bZX) * S("Z'") - m.gYX * S("Y'"))

    values = {x: p[0], y: p[1], z: p[2], i: v[0], j: v[1], k: v[2]}

    def first_order(expression, steps):
        """d/dt at t = 0, where primed commands are q + t dq."""
        moved = {S(f"{name}'"): S(name) + t * dq for name, dq in steps.items()}
        # Errors to t * error first: the steps hold errors of their own.
        slope = sympy.diff(expression.subs(errors, simultaneous=True).subs(moved, simultaneous=True), t)
        return slope.subs(t, 0).subs(values, simultaneous=True)

    steps = {"C": first_order(c_new, {}), "A": first_order(a_new, {})}
    steps["Z"] = first_order(z_new, steps)
    steps["Y"] = first_order(y_new, steps)
    steps["X"] = first_order(x_new, steps)
    left = {}
    for member, ideal in (("deviation", p), ("tool_axis", v)):
        left[member] = {key: -sum(sympy.diff(ideal[n], S(axis)) * dq for axis, dq in steps.items())
                        for n, key in enumerate("xyz")}
    return left


def zero_at_random_points(expression):
    """0 if the expression vanishes to 40 digits at three points with 0 < A < pi, else a value of it: the
    roots of the closed form have no normal form."""
    import random

    generator = random.Random(20260302)
    for _ in range(3):
        point = {symbol: sympy.Rational(generator.randint(1, 3000), 1000) for symbol in expression.free_symbols}
        value = sympy.N(expression.subs(point), 50)
        if abs(value) > sympy.Float(10) ** -40 * 10000:
            return value
    return 0


def cases():
    yield {"origin": "seed 000 (28), (31)", "machine": "seed_000", "equations": seed_000()}
    for squareness in ("after", "frame", "line"):
        yield {"origin": f"seed 001 (26), {squareness}", "machine": f"seed_001_{squareness}",
               "equations": seed_001(squareness)}
    offset = [sympy.Rational(n) for n in ("1/2", "-1/4", "-120")]
    yield {"origin": "seed 001 (26) with a tool offset", "machine": "seed_001_after_tool_offset",
           "equations": seed_001("after", *offset)}
    yield {"origin": "seed 002 (10)-(15)", "machine": "seed_002", "equations": seed_002()}
    yield {"origin": "seed 003 (1)", "machine": "seed_003", "equations": seed_003_matrices()}
    yield {"origin": "seed 003, closed form", "machine": "seed_003", "equations": seed_003_closed_form,
           "zero": zero_at_random_points}

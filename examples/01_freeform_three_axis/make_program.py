#!/usr/bin/env python3
"""Writes freeform.ngc: a ball-end mill finishes a wavy 240 x 160 mm surface in a zigzag, mills the
boundary with arcs in and out, then drills four holes. Deterministic; run it again to change the part.

    python3 make_program.py > freeform.ngc
"""

import math

WIDTH, DEPTH = 240.0, 160.0  # mm, the part; its zero is the lower left corner of the raw surface
RADIUS = 4.0                # mm, ball-end mill
STEP_OVER, STEP = 2.5, 4.0  # mm, between and along the lines


def surface(x, y):
    """Height of the finished surface and its slopes: a saddle with a soft wave."""
    u, v = x / WIDTH - 0.5, y / DEPTH - 0.5
    z = -9.0 + 14.0 * (u * u - v * v) + 5.0 * math.sin(2 * math.pi * u) * math.cos(math.pi * v)
    dz_du = 28.0 * u + 5.0 * 2 * math.pi * math.cos(2 * math.pi * u) * math.cos(math.pi * v)
    dz_dv = -28.0 * v - 5.0 * math.pi * math.sin(2 * math.pi * u) * math.sin(math.pi * v)
    return z, dz_du / WIDTH, dz_dv / DEPTH


def tip(x, y):
    """Tip of a ball that touches the surface above (x, y): centre = point + R n, tip = centre - R z."""
    z, zx, zy = surface(x, y)
    n = math.sqrt(zx * zx + zy * zy + 1)
    return x - RADIUS * zx / n, y - RADIUS * zy / n, z + RADIUS / n - RADIUS


def main():
    out = []
    say = out.append
    say("%")
    say("(FREEFORM INSERT, FINISHING)")
    say("(ZERO: LOWER LEFT CORNER, TOP OF THE STOCK)")
    say("N10 G21 G17 G90 G94 G40 G49 G80")
    say("N20 T1 M6 (BALL-END MILL R4)")
    say("N30 G54 G43 H1")
    say("N40 S12000 M3 M8")
    say("N50 G0 X0. Y0. Z25.")
    say("(ZIGZAG)")
    lines = int(round(DEPTH / STEP_OVER))
    columns = int(round(WIDTH / STEP))
    for row in range(lines + 1):
        y = row * STEP_OVER
        for i in range(columns + 1):
            column = i if row % 2 == 0 else columns - i
            px, py, pz = tip(column * STEP, y)
            if row == 0 and i == 0:
                say(f"G0 X{px:.4f} Y{py:.4f} Z5.")
                say(f"G1 Z{pz:.4f} F600")
                continue
            feed = " F2400" if row == 0 and i == 1 else ""
            say(f"G1 X{px:.4f} Y{py:.4f} Z{pz:.4f}{feed}")
    say("G0 Z25.")
    say("(BOUNDARY AT Z-20, CLIMB, ARCS IN AND OUT, CORNERS ROUNDED WITH R6)")
    say("G0 X-14. Y80.")
    say("Z2.")
    say("G1 Z-20. F500")
    say("G3 X-4. Y90. I0. J10. F1500")
    say("G1 Y158.")
    say("G2 X2. Y164. I6. J0.")
    say("G1 X238.")
    say("G2 X244. Y158. I0. J-6.")
    say("G1 Y2.")
    say("G2 X238. Y-4. R6.")
    say("G1 X2.")
    say("G2 X-4. Y2. I0. J6.")
    say("G1 Y90.")
    say("G3 X-14. Y100. R10.")
    say("G0 Z25.")
    say("M9")
    say("M5")
    say("(FOUR HOLES)")
    say("T2 M6 (DRILL D6)")
    say("G43 H2")
    say("S3200 M3 M8")
    say("G0 X10. Y10. Z25.")
    say("G98 G81 X10. Y10. Z-24. R-6. F320")
    say("X230.")
    say("Y150.")
    say("X10.")
    say("G80")
    say("M9")
    say("M5")
    say("G0 Z50.")
    say("M30")
    say("%")
    print("\n".join(out))


if __name__ == "__main__":
    main()

"""Denoised records of `abbe filter` equal those that PyWavelets makes, to 1e-12 of the largest sample."""
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import warnings

try:
    import numpy
    import pywt
except ImportError as missing:
    print(f"{missing}: skipped")
    sys.exit(77)

ABBE = sys.argv[1]
ROUNDING = 1e-12
warnings.filterwarnings("ignore", message="Level value")


def by_pywavelets(x, wavelet, levels, mode, sigma, count):
    coefficients = pywt.wavedec(x, wavelet, mode="symmetric", level=levels)
    total = len(x) if count == "samples" else sum(len(c) for c in coefficients)
    finest = coefficients[-1]
    for i in range(1, len(coefficients)):
        of = finest if sigma == "first" else coefficients[i]
        s = 1.0 if sigma == "one" else numpy.median(numpy.abs(of)) / 0.6745
        threshold = s * math.sqrt(2 * math.log(total))
        c = coefficients[i]
        kept = numpy.abs(c) > threshold  # pywt.threshold keeps equal ones, too
        small = c if mode == "hard" else numpy.sign(c) * (numpy.abs(c) - threshold)
        coefficients[i] = numpy.where(kept, small, 0.0)
    return pywt.waverec(coefficients, wavelet, mode="symmetric")[:len(x)]


def read_columns(path):
    """The only column of a column file (docs/theory/captures.md)."""
    with open(path, "rb") as file:
        assert file.read(8) == b"ABBECOL1"
        file.read(struct.unpack("<Q", file.read(8))[0])
        blocks = []
        while rows := struct.unpack("<Q", file.read(8))[0]:
            blocks.append(numpy.fromfile(file, "<f8", 2 * rows).reshape(2, rows))
    return numpy.hstack(blocks)[1]


def by_abbe(folder, x, step):
    signals, out = folder / "x.csv", folder / "y.abbecol"
    with open(signals, "w") as file:
        file.write("x\n" + "\n".join(repr(float(v)) for v in x) + "\n")
    subprocess.run([ABBE, "filter", str(signals), "--dt", "0.001", "--step", step, "-o", str(out)], check=True)
    return read_columns(out)


generator = numpy.random.default_rng(4)
compared = 0
with tempfile.TemporaryDirectory() as scratch:
    folder = pathlib.Path(scratch)
    for i, wavelet in enumerate([f"db{p}" for p in range(1, 21)] + [f"sym{p}" for p in range(2, 21)]):
        n = [2, 7, 64, 999, 5000][i % 5]
        mode, sigma = ["hard", "soft"][i % 2], ["first", "per_level", "one"][i % 3]
        count, levels = ["samples", "coefficients"][i // 2 % 2], 1 + i % 6
        t = numpy.arange(n) / 100
        x = 10 * numpy.sin(t) + generator.normal(0, 1, n)
        name = {"per_level": "level"}.get(sigma, sigma)
        ours = by_abbe(folder, x, f"wavelet={wavelet},levels={levels},{mode},sigma={name},count={count}")
        theirs = by_pywavelets(x, wavelet, levels, mode, sigma, count)
        difference = numpy.max(numpy.abs(ours - theirs)) / numpy.max(numpy.abs(x))
        if not difference <= ROUNDING:
            sys.exit(f"{wavelet}, {n} samples, {levels} levels, {mode}, {sigma}, {count}: differs by {difference}")
        compared += 1
print(f"{compared} records equal those of PyWavelets {pywt.__version__} to {ROUNDING}")

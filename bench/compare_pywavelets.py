#!/usr/bin/env python3
"""Denoising beside PyWavelets: sym5, 5 levels, universal threshold of the median, soft.

    bench/compare_pywavelets.py [BUILD [SAMPLES [ROUNDS]]]       default build/release 1000000 7

Both on one core in turn, processor time of the best round. Needs build/release and python3-pywt.
"""
import math
import subprocess
import sys
import time

import numpy
import pywt

build = sys.argv[1] if len(sys.argv) > 1 else "build/release"
samples = int(sys.argv[2]) if len(sys.argv) > 2 else 1000000
rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 7


def denoise(x):
    c = pywt.wavedec(x, "sym5", mode="symmetric", level=5)
    threshold = numpy.median(numpy.abs(c[-1])) / 0.6745 * math.sqrt(2 * math.log(len(x)))
    c[1:] = [pywt.threshold(d, threshold, "soft") for d in c[1:]]
    return pywt.waverec(c, "sym5", mode="symmetric")


x = 10 * numpy.sin(1e-3 * numpy.arange(samples)) + numpy.random.default_rng(1).normal(0, 1, samples)
theirs = ours = math.inf
for _ in range(rounds):
    begin = time.process_time()
    denoise(x)
    theirs = min(theirs, time.process_time() - begin)
    text = subprocess.run(["taskset", "-c", "0", f"{build}/bench/denoise_times", str(samples), "3"], check=True,
                          capture_output=True, text=True).stdout
    ours = min(ours, float(text.split()[0]))
print(f"{samples} samples: abbe {ours * 1e3:.2f} ms, PyWavelets {theirs * 1e3:.2f} ms, ratio {theirs / ours:.2f}")

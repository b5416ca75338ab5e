"""Writes sin_cos.csv.gz: arguments and their sines and cosines as bit patterns, rounded from 60 more digits.

Run with mpmath installed: python3 sin_cos.py | gzip -9n > sin_cos.csv.gz
"""
import random
import struct

import mpmath

mpmath.mp.prec = 2400
random.seed(1)


def bits(value):
    return struct.unpack("<Q", struct.pack("<d", value))[0]


def from_bits(pattern):
    return struct.unpack("<d", struct.pack("<Q", pattern))[0]


def arguments():
    yield from (0.0, 5e-324, 1e-310, 2.2250738585072014e-308, 1e-300, 1e-30, 1e-9, 1e-8, 0.5, 1.0, 2.0)
    yield from (2.0**20, from_bits(bits(2.0**20) + 1), 2.0**52, 2.0**53, 1e22, 1.7976931348623157e308)
    # The double closest to a multiple of pi/2 (Muller, Elementary Functions, section 11.2).
    yield 6381956970095103.0 * 2.0**797
    # Doubles next to multiples of pi/2, and next to the borders between quadrants.
    steps = list(range(1, 40)) + [2**k + d for k in range(6, 20) for d in (-1, 0, 1)] + [667543, 667544, 667545]
    steps += [random.randrange(2**19) for _ in range(300)] + [10**k for k in range(6, 22, 3)]
    for n in steps:
        for quarter in (2 * n - 1, 2 * n):
            x = float(mpmath.pi / 4 * quarter)
            yield from (from_bits(bits(x) + d) for d in (-1, 0, 1))
    # The convergents of pi/2 give arguments that are closer still.
    x, a, b = mpmath.pi / 2, (0, 1), (1, 0)
    while a[1] < 2**1000:
        q = int(x)
        a, b = (a[1], q * a[1] + a[0]), (b[1], q * b[1] + b[0])
        x = 1 / (x - q)
        if float(a[1]) == a[1]:
            yield float(a[1])
    # Remainders of every size: where a later part of pi/2 is as large as the last place, two steps round.
    for k in range(5, 45):
        for _ in range(25):
            n = random.randrange(2**19, 667000)
            yield float(n * mpmath.pi / 2 + 2.0 ** -(k + random.random()))
    for _ in range(600):
        yield random.uniform(0, 10)
    for _ in range(600):
        yield 2.0 ** random.uniform(-60, 20)
    for _ in range(600):
        yield 2.0 ** random.uniform(20, 1023)


for x in arguments():
    sine, cosine = mpmath.sin(mpmath.mpf(x)), mpmath.cos(mpmath.mpf(x))
    rows = [bits(x)]
    for value in (sine, cosine):
        high = float(value)
        # The remainder lets a test measure errors below half a unit in the last place.
        rows += [bits(high), bits(float(value - mpmath.mpf(high)))]
    print(",".join(f"{row:016x}" for row in rows))

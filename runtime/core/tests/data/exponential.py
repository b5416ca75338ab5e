"""Writes exponential.csv.gz: bits of x, and of e^x and tanh x as a double and the remainder that makes it exact.

Needs mpmath: python3 exponential.py | gzip -9n > exponential.csv.gz
"""
import random
import struct

import mpmath

mpmath.mp.prec = 200
random.seed(1)


def bits(x):
    return f"{struct.unpack('>Q', struct.pack('>d', x))[0]:016x}"


def exact(value):
    high = float(value)
    return bits(high) + "," + bits(float(value - mpmath.mpf(high)))


for k in range(3000):
    x = random.choice([-1, 1]) * 10 ** (random.uniform(-3, 1.3) if k % 8 else random.uniform(-20, 2.84))
    print(",".join([bits(x), exact(mpmath.exp(x)), exact(mpmath.tanh(x))]))

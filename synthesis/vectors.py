#!/usr/bin/env python3
"""Prints random and special fp32 operands and what the operators must give (round to nearest even, subnormals as zero but in comparisons):
a b a+b a-b a*b a<b min max, hexadecimal, one pair a line."""
import math
import random
import struct
import sys
from fractions import Fraction

QUIET_NAN = 0x7FC00000


def number(bits):
    sign = -1 if bits >> 31 else 1
    exponent, fraction = bits >> 23 & 255, bits & 0x7FFFFF
    if exponent == 255:
        return math.nan if fraction else sign * math.inf
    return sign * 0.0 if exponent == 0 else struct.unpack("<f", struct.pack("<I", bits))[0]


def exactly(bits):
    """Comparisons take subnormal numbers as what they are."""
    return struct.unpack("<f", struct.pack("<I", bits))[0]


def rounded(exact, sign):
    """fp32 of an exact, finite number; sign: of a zero."""
    if exact == 0:
        return sign << 31
    sign, size = int(exact < 0), abs(exact)
    exponent = size.numerator.bit_length() - size.denominator.bit_length()
    if Fraction(2) ** exponent > size:
        exponent -= 1
    scaled = size / Fraction(2) ** (exponent - 23)  # in [2^23, 2^24)
    whole = scaled.numerator // scaled.denominator
    rest = scaled - whole
    if rest > Fraction(1, 2) or (rest == Fraction(1, 2) and whole & 1):
        whole += 1
    if whole == 1 << 24:
        whole, exponent = whole >> 1, exponent + 1
    if exponent < -126:
        return sign << 31
    if exponent > 127:
        return sign << 31 | 0x7F800000
    return sign << 31 | exponent + 127 << 23 | whole & 0x7FFFFF


def infinite(value):
    return QUIET_NAN if math.isnan(value) else 0xFF800000 if value < 0 else 0x7F800000


def add(a, b):
    x, y = number(a), number(b)
    if not (math.isfinite(x) and math.isfinite(y)):
        return infinite(x + y)
    return rounded(Fraction(x) + Fraction(y), a >> 31 & b >> 31)


def multiply(a, b):
    x, y = number(a), number(b)
    if not (math.isfinite(x) and math.isfinite(y)):
        return infinite(x * y)
    return rounded(Fraction(x) * Fraction(y), (a ^ b) >> 31)


def operands(generator):
    special = [0, 1 << 31, 0x7F800000, 0xFF800000, QUIET_NAN, 1, 0x7FFFFF, 0x800000, 0x7F7FFFFF, 0x3F800000, 0xBF800000]
    for a in special:
        for b in special:
            yield a, b
    while True:
        a = generator.getrandbits(32)
        kind = generator.randrange(4)
        b = generator.getrandbits(32)
        if kind == 1:  # exponents next to each other: cancellation, rounding
            b = b & 0x807FFFFF | min(254, max(0, (a >> 23 & 255) + generator.randint(-26, 26))) << 23
        elif kind == 2:  # nearly equal
            b = (a ^ 1 << 31) + generator.randint(-4, 4) & 0xFFFFFFFF
        elif kind == 3:  # products at the ends of the range
            b = b & 0x807FFFFF | min(254, max(0, generator.choice((127, 381)) - (a >> 23 & 255) + generator.randint(-2, 2))) << 23
        yield a, b


def main():
    count = int(sys.argv[1])
    for _, (a, b) in zip(range(count), operands(random.Random(1))):
        less = int(exactly(a) < exactly(b))
        words = (a, b, add(a, b), add(a, b ^ 1 << 31), multiply(a, b))
        print(*(f"{w:08x}" for w in words), less, f"{a if less else b:08x} {b if less else a:08x}")


main()

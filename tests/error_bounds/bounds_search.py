"""How near real rounding errors come to the bounds of the core: a random search in exact arithmetic.

`python tests/error_bounds/bounds_search.py [rounds]` prints the largest error found as a part of each bound. The
operations are those of the C++ lines, in the same order; errors are exact fractions. It climbs: the worst case so far
is varied.
"""

import math
import random
import sys
from collections.abc import Callable, Sequence
from fractions import Fraction

import numpy as np
from gappa_proofs import value

Numbers = list[float]
F = Fraction


def dot3(a: Sequence[float], b: Sequence[float]) -> float:
    """(a0 b0 + a1 b1) + a2 b2."""
    return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]


def cross3(a: Sequence[float], b: Sequence[float]) -> Numbers:
    """As vec.hpp, cross."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def exact_dot(a: Sequence[F | float], b: Sequence[F | float]) -> F:
    return sum((F(x) * F(y) for x, y in zip(a, b, strict=True)), F(0))


def exact_cross(a: Sequence[F], b: Sequence[F]) -> list[F]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def along(n: Numbers) -> F:
    """kAlongError: u · (a − b)."""
    u, a, b = n[:3], n[3:6], n[6:9]
    e, true = [x - y for x, y in zip(a, b, strict=True)], [F(x) - F(y) for x, y in zip(a, b, strict=True)]
    size = exact_dot([abs(x) for x in u], [abs(x) for x in true])
    return abs(F(dot3(u, e)) - exact_dot(u, true)) / size / value("predicates", "kAlongError")


def determinant(n: Numbers) -> F:
    """kDeterminantError: orientation(a, b, c, d)."""
    a = n[:3]
    rows = [[x - y for x, y in zip(n[k : k + 3], a, strict=True)] for k in (3, 6, 9)]
    true = [[F(x) - F(y) for x, y in zip(n[k : k + 3], a, strict=True)] for k in (3, 6, 9)]
    found, exact = dot3(cross3(rows[0], rows[1]), rows[2]), exact_dot(exact_cross(true[0], true[1]), true[2])
    p, q, r = ([abs(x) for x in row] for row in true)
    size = sum(p[i] * q[j] * r[k] for i in range(3) for j in range(3) for k in range(3) if len({i, j, k}) == 3)
    return abs(F(found) - exact) / size / value("predicates", "kDeterminantError")


def side(n: Numbers) -> F:
    """kSideBound: a body_a's vertex and a body_b's line, with both poses."""
    (m0, m1, tx, m3, m4, ty), (h0, h1, sx, h3, h4, sy), (x, y, fx, fy, gx, gy) = n[:6], n[6:12], n[12:18]
    vx, vy = gx - fx, gy - fy
    dx, dy = h0 * vx + h1 * vy, h3 * vx + h4 * vy
    px, py = m0 * x + m1 * y + (tx - sx), m3 * x + m4 * y + (ty - sy)
    found = dx * (py - (h3 * fx + h4 * fy)) - dy * (px - (h0 * fx + h1 * fy))

    def terms(*pairs: tuple[float | F, float | F]) -> tuple[F, F]:
        return sum((F(a) * F(b) for a, b in pairs), F(0)), sum((abs(F(a) * F(b)) for a, b in pairs), F(0))

    wx, wy, ox, oy = F(gx) - F(fx), F(gy) - F(fy), F(tx) - F(sx), F(ty) - F(sy)
    ex, size_dx = terms((h0, wx), (h1, wy))
    ey, size_dy = terms((h3, wx), (h4, wy))
    rx, size_x = terms((m0, x), (m1, y), (ox, 1), (-F(h0), fx), (-F(h1), fy))
    ry, size_y = terms((m3, x), (m4, y), (oy, 1), (-F(h3), fx), (-F(h4), fy))
    size = size_dx * size_y + size_dy * size_x
    return abs(F(found) - (ex * ry - ey * rx)) / size / value("polygon_signs", "kSideBound")


def rotation(n: Numbers) -> list[Numbers]:
    """Of a quaternion of any length, rounded: rows."""
    length = math.sqrt(sum(x * x for x in n)) or 1.0
    w, x, y, z = (v / length for v in n)
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def root_above(x: F) -> F:
    """sqrt, rounded up a little."""
    return F(math.sqrt(x)) * (1 + F(1, 2**50))


def root_below(x: F) -> F:
    return F(math.sqrt(x)) * (1 - F(1, 2**50))


def _corner(n: Numbers) -> tuple[Numbers, list[F], F, tuple[list[Numbers], list[Numbers]]]:
    """The computed and the exact difference of two posed vertices, and the size."""
    m, r = rotation(n[:4]), rotation(n[4:8])
    p, q, t, s = n[8:11], n[11:14], n[14:17], n[17:20]
    w = [a - b for a, b in zip(t, s, strict=True)]
    found = [(dot3(row, p) - dot3(other, q)) + shift for row, other, shift in zip(m, r, w, strict=True)]
    true = [exact_dot(m[i], p) - exact_dot(r[i], q) + F(t[i]) - F(s[i]) for i in range(3)]
    lengths = [root_above(exact_dot(v, v)) for v in (p, q)]
    return found, true, lengths[0] + lengths[1] + sum((abs(F(x)) for x in w), F(0)), (m, r)


def corner(n: Numbers) -> F:
    """kDifference of minkowski_difference."""
    found, true, size, _ = _corner(n)
    off = [F(a) - b for a, b in zip(found, true, strict=True)]
    return root_above(exact_dot(off, off)) / size / value("minkowski_difference", "kDifference")


def support(n: Numbers) -> F:
    """kSupport of minkowski_difference: the vertex found is as high as another by a rounded direction's products."""
    found, true, size, (m, r) = _corner(n)
    d = n[20:23]
    inverse = 1 / math.sqrt(dot3(d, d))
    d = [inverse * x for x in d]
    loss = F(0)
    for pose, vertex, other, sign in ((m, n[8:11], n[23:26], -1), (r, n[11:14], n[26:29], 1)):
        u = [sign * dot3([row[j] for row in pose], d) for j in range(3)]
        # The other vertex, no longer than this one: of both the scan takes the one that it sees further.
        if exact_dot(other, other) > exact_dot(vertex, vertex) or dot3(u, other) > dot3(u, vertex):
            continue
        exact = [sign * sum(F(row[j]) * F(x) for row, x in zip(pose, d, strict=True)) for j in range(3)]
        loss += max(F(0), exact_dot(exact, other) - exact_dot(exact, vertex))
    length = root_below(exact_dot(d, d))
    off = F(dot3(d, found)) - (exact_dot(d, true) - loss) / length
    return off / size / value("minkowski_difference", "kSupport")


def scan(n: Numbers) -> F:
    """kScanError: a rounded product."""
    u, p = n[:3], n[3:6]
    size = sum((abs(F(x)) for x in u), F(0)) * max(abs(F(x)) for x in p)
    return abs(F(dot3(u, p)) - exact_dot(u, p)) / size / value("support", "kScanError")


def two_sum(a: float, b: float) -> tuple[float, float]:
    """As double_double.hpp."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def quick_two_sum(a: float, b: float) -> tuple[float, float]:
    return a + b, b - ((a + b) - a)


def double2(n: Numbers) -> F:
    """kDoubleDoubleError: the larger of a sum's and a product's."""
    (ah, al), (bh, bl) = two_sum(n[0], n[1] * 2.0**-53), two_sum(n[2], n[3] * 2.0**-53)
    a, b = F(ah) + F(al), F(bh) + F(bl)
    high, low = two_sum(ah, bh), two_sum(al, bl)
    total = quick_two_sum(high[0], high[1] + low[0])
    total = quick_two_sum(total[0], total[1] + low[1])
    product = ah * bh
    exact_low = float(F(ah) * F(bh) - F(product))  # as two_product finds it
    times = quick_two_sum(product, exact_low + (ah * bl + al * bh))
    off_sum = abs(F(total[0]) + F(total[1]) - (a + b)) / (abs(a) + abs(b))
    off_product = abs(F(times[0]) + F(times[1]) - a * b) / abs(a * b)
    return max(off_sum, off_product) / value("double_double", "kDoubleDoubleError")


def float_tie(n: Numbers) -> F:
    """kFloatTie: twice what a product in floats is off by."""
    u, p = n[:3], n[3:6]
    length = max(abs(x) for x in u)
    single = np.float32
    x, y, z = (single(a) * single(b) for a, b in zip(u, p, strict=True))
    return 2 * abs(F(float((x + y) + z)) - exact_dot(u, p)) / F(length) / value("support_scan", "kFloatTie")


def posed(n: Numbers) -> F:
    """kPairError: of a body_a's vertex in the body_b's frame, which is part (a) of it."""
    m, r = rotation(n[:4]), rotation(n[4:8])
    p, t, s, c = n[8:11], n[11:14], n[14:17], n[17:20]
    relative = [[dot3([r[k][i] for k in range(3)], [m[k][j] for k in range(3)]) for j in range(3)] for i in range(3)]
    w = [a - b for a, b in zip(t, s, strict=True)]
    shift = [dot3([r[k][i] for k in range(3)], w) - c[i] for i in range(3)]
    found = [(a[0] * p[0] + a[1] * p[1]) + (a[2] * p[2] + b) for a, b in zip(relative, shift, strict=True)]
    world = [exact_dot(m[k], p) + F(t[k]) - F(s[k]) for k in range(3)]
    true = [exact_dot([r[k][i] for k in range(3)], world) - F(c[i]) for i in range(3)]
    off = [F(a) - b for a, b in zip(found, true, strict=True)]
    sizes = root_below(exact_dot(p, p)) + sum((abs(F(x)) for x in (*w, *c)), F(0))
    return root_above(exact_dot(off, off)) / sizes / value("pair_frame", "kPairError")


SEARCHED: dict[str, tuple[Callable[[Numbers], F], int]] = {
    "predicates/kAlongError": (along, 9),
    "predicates/kDeterminantError": (determinant, 12),
    "polygon_signs/kSideBound": (side, 18),
    "support/kScanError": (scan, 6),
    "double_double/kDoubleDoubleError": (double2, 4),
    "support_scan/kFloatTie": (float_tie, 6),
    "pair_frame/kPairError": (posed, 20),
    "minkowski_difference/kDifference": (corner, 20),
    "minkowski_difference/kSupport": (support, 29),
}


def search(error: Callable[[Numbers], F], count: int, rounds: int, seed: int) -> F:
    """The largest error found, by climbs from random numbers."""
    rng = random.Random(seed)
    best = F(0)
    for _ in range(4):
        numbers, here = [], F(-1)
        for turn in range(rounds // 4):
            if (turn % 8 == 0 and here < F(1, 5)) or not numbers:
                tried = [rng.uniform(-1, 1) for _ in range(count)]
            else:
                tried = list(numbers)
                for k in rng.sample(range(count), rng.randint(1, 3)):
                    tried[k] = tried[k] * (1 + rng.uniform(-1, 1) * 10 ** rng.uniform(-16, 0))
            try:
                found = error(tried)
            except ZeroDivisionError:
                continue
            if found > here:
                numbers, here = tried, found
        best = max(best, here)
    return best


def main() -> None:
    """Prints the largest errors."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 20000
    for name, (error, count) in SEARCHED.items():
        print(f"{name} {float(search(error, count, rounds, 1)):.2f}", flush=True)


if __name__ == "__main__":
    main()

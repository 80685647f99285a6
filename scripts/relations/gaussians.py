# SPDX-License-Identifier: Apache-2.0
"""Scenes and cameras as Python values: read what grtx synth made, move, turn, scale, cut, write."""
import json
import math
import random
import struct

# What an image may lose where fp32 rounds otherwise: hits that trade places, Gaussians on the edge of what counts.
ROUNDED = 50.0  # dB
PRESETS = ["hall", "building", "room", "object", "flat", "garden"]
STRESS = ["stress-ties", "stress-copies", "stress-needles", "stress-tiny", "stress-params", "stress-quaternions",
          "stress-opacity", "stress-far", "stress-axis", "stress-inside", "stress-onepoint", "stress-empty", "stress-one",
          "stress-nohit"]
GRID = 2.0 ** -12  # scene units: positions on it, and their median, are exact in float


class Row:
    """A Gaussian as a .ply has it. place: double; sh: coefficient-major, a list of three colours each."""
    __slots__ = ("place", "sh", "opacity", "scale", "turn")

    def __init__(self, place, sh, opacity, scale, turn):
        self.place, self.sh, self.opacity, self.scale, self.turn = place, sh, opacity, scale, turn

    def with_(self, **changes):
        return Row(**{**{name: getattr(self, name) for name in self.__slots__}, **changes})


def fp32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def read_ply(path):
    """Rows of a .ply as grtx synth and write_ply() write it."""
    with open(path, "rb") as file:
        head, body = file.read().split(b"end_header\n", 1)
    properties = [line.decode().split()[1:] for line in head.splitlines() if line.startswith(b"property ")]
    names, record = [name for _, name in properties], struct.Struct("<" + "".join(kind[0] for kind, _ in properties))
    count = next(int(line.split()[-1]) for line in head.splitlines() if line.startswith(b"element vertex"))
    rows, rest = [], sum(name.startswith("f_rest_") for name in names) // 3
    for i in range(count):
        value = dict(zip(names, record.unpack_from(body, record.size * i)))
        sh = [[value[f"f_dc_{c}"] for c in range(3)]]
        sh += [[value[f"f_rest_{c * rest + j}"] for c in range(3)] for j in range(rest)]
        rows.append(Row([value[a] for a in "xyz"], sh, value["opacity"], [value[f"scale_{a}"] for a in range(3)],
                        [value[f"rot_{a}"] for a in range(4)]))
    return rows


def write_ply(path, rows):
    """Positions in double, all else in float."""
    rest = len(rows[0].sh) - 1 if rows else 0
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}"]
    head += [f"property double {a}" for a in "xyz"]
    names = [f"f_dc_{c}" for c in range(3)] + [f"f_rest_{j}" for j in range(3 * rest)] + ["opacity"]
    names += [f"scale_{a}" for a in range(3)] + [f"rot_{a}" for a in range(4)]
    head += [f"property float {name}" for name in names]
    with open(path, "wb") as file:
        file.write(("\n".join(head) + "\nend_header\n").encode())
        for row in rows:
            colours = row.sh[0] + [row.sh[1 + j][c] for c in range(3) for j in range(rest)]
            file.write(struct.pack(f"<3d{len(names)}f", *row.place, *colours, row.opacity, *row.scale, *row.turn))


def of_degree_4(rows, seed):
    """The rows with harmonics of the highest degree, which grtx synth does not make."""
    rng = random.Random(seed)
    return [row.with_(sh=row.sh + [[rng.gauss(0, 0.1) for _ in range(3)] for _ in range(25 - len(row.sh))]) for row in rows]


def read_cameras(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def write_cameras(path, cameras):
    with open(path, "w", encoding="utf-8") as file:
        json.dump(cameras, file, indent=1)


def resized(camera, width, height):
    """As --width and --height do."""
    x, y = width / camera["width"], height / camera["height"]
    return {**camera, "width": width, "height": height, "fx": camera["fx"] * x, "fy": camera["fy"] * y,
            "cx": camera.get("cx", camera["width"] / 2) * x, "cy": camera.get("cy", camera["height"] / 2) * y}


# Turns.

def times(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def applied(matrix, vector):
    return [sum(m * v for m, v in zip(row, vector)) for row in matrix]


def random_turn(rng):
    """A unit quaternion w, x, y, z."""
    q = [rng.gauss(0, 1) for _ in range(4)]
    length = math.sqrt(sum(v * v for v in q))
    return [v / length for v in q]


def product(a, b):
    """Of quaternions: b first, then a."""
    return [a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]]


def matrix_of(q):
    w, x, y, z = q
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


# Spherical harmonics of a unit direction, degrees 1 to 4, in the order of 3DGS, without the factors below.

def harmonics(degree, d):
    x, y, z = d
    if degree == 4:
        return [x * y * (x * x - y * y), y * z * (3 * x * x - y * y), x * y * (7 * z * z - 1), y * z * (7 * z * z - 3),
                z * z * (35 * z * z - 30) + 3, x * z * (7 * z * z - 3), (x * x - y * y) * (7 * z * z - 1), x * z * (x * x - 3 * y * y),
                x * x * (x * x - 3 * y * y) - y * y * (3 * x * x - y * y)]
    return {1: [y, z, x], 2: [x * y, y * z, 2 * z * z - x * x - y * y, x * z, x * x - y * y],
            3: [y * (3 * x * x - y * y), x * y * z, y * (4 * z * z - x * x - y * y), z * (2 * z * z - 3 * x * x - 3 * y * y),
                x * (4 * z * z - x * x - y * y), z * (x * x - y * y), x * (x * x - 3 * y * y)]}[degree]


FACTORS = {1: [-0.4886025119029199, 0.4886025119029199, -0.4886025119029199],
           2: [1.0925484305920792, -1.0925484305920792, 0.31539156525252005, -1.0925484305920792, 0.5462742152960396],
           3: [-0.5900435899266435, 2.890611442640554, -0.4570457994644658, 0.3731763325901154, -0.4570457994644658,
               1.445305721320277, -0.5900435899266435],
           4: [2.5033429417967046, -1.7701307697799304, 0.9461746957575601, -0.6690465435572892, 0.10578554691520431,
               -0.6690465435572892, 0.47308734787878004, -1.7701307697799304, 0.6258357354491761]}


def solved(matrix, right):
    """matrix^-1 right, by elimination; right: a matrix."""
    n = len(matrix)
    rows = [list(matrix[i]) + list(right[i]) for i in range(n)]
    for c in range(n):
        pivot = max(range(c, n), key=lambda r: abs(rows[r][c]))
        rows[c], rows[pivot] = rows[pivot], rows[c]
        for r in range(n):
            if r != c and rows[r][c] != 0.0:
                factor = rows[r][c] / rows[c][c]
                rows[r] = [a - factor * b for a, b in zip(rows[r], rows[c])]
    return [[v / rows[i][i] for v in rows[i][n:]] for i in range(n)]


def turned_harmonics(turn, rng):
    """A function of a row's sh: coefficients with which the turned row has, seen from the turned direction, its colour."""
    back = [list(column) for column in zip(*turn)]
    blocks = {}
    for degree, factors in FACTORS.items():
        size = 2 * degree + 1
        directions = [[rng.gauss(0, 1) for _ in range(3)] for _ in range(size + 2)][:size]
        basis = [[f * v for f, v in zip(factors, harmonics(degree, unit(d)))] for d in directions]
        before = [[f * v for f, v in zip(factors, harmonics(degree, unit(applied(back, d))))] for d in directions]
        blocks[degree] = solved(basis, before)

    def apply(sh):
        out, at = sh[:1], 1
        for degree, block in blocks.items():
            own = sh[at:at + 2 * degree + 1]
            if not own:
                break
            out = out + [[sum(b * own[k][c] for k, b in enumerate(line)) for c in range(3)] for line in block]
            at += 2 * degree + 1
        return out
    return apply


def unit(d):
    length = math.sqrt(sum(v * v for v in d))
    return [v / length for v in d]


def flipped_harmonics(signs):
    """The same for a mirror of axes: every basis function keeps its value or changes its sign. Exact."""
    probe, flips = unit((0.3, 0.5, 0.7)), []
    for degree in FACTORS:
        for a, b in zip(harmonics(degree, probe), harmonics(degree, [s * v for s, v in zip(signs, probe)])):
            flips.append(-1.0 if a * b < 0 else 1.0)
    return lambda sh: sh[:1] + [[f * v for v in colour] for f, colour in zip(flips, sh[1:])]


# A scene with which exact moves are exact.

def exact_scale(value, power):
    """(a, b): logarithms in float, near `value`, with exp(b) = 2^power exp(a) once both are rounded to float. There are some for
    even powers: 2 ln 2 is 4e-9 off a multiple of 2^-20, the step of a float between 8 and 16."""
    for i in range(1000):
        a = fp32(value + i * 1.37e-6)
        b = fp32(a + power * math.log(2.0))
        if fp32(math.exp(b)) == math.ldexp(fp32(math.exp(a)), power):
            return a, b
    raise ArithmeticError(f"no scale near {value} for a power of {power}")


def on_grid(value, grid=GRID):
    return round(value / grid) * grid

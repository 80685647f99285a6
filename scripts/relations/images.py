# SPDX-License-Identifier: Apache-2.0
"""Relations of images: what must not change them, and what must change them in a known way."""
import math

from . import gaussians, views
from .case import relation


def rendered(case, name, *options):
    """An image by grtx trace."""
    case.grtx("trace", *options, "--no-trace", "--image", f"{name}.pfm", "--quiet")
    return case.image(f"{name}.pfm")


@relation()
def walks_agree(case):
    """k, structure, checkpoints, orders, layouts, widths, warps, ways to trace and threads leave the image alone, to the bit."""
    preset = views.scene(case, presets=gaussians.PRESETS + gaussians.STRESS)
    proxy = case.rng.choice(["icosahedron", "icosahedron", "icosphere", "sphere", "box"])
    view = ["--scene", "s.ply", *views.view(case), *views.shading(case.rng, proxy)]
    first = rendered(case, "a", *view, *views.walk(case.rng, proxy))
    for name in "bc":
        case.same(f"{preset}: two walks", first, rendered(case, name, *view, *views.walk(case.rng, proxy)))


@relation()
def one_round_agrees(case):
    """--tracing single, with room for all hits or not, gives the image of the rounds, to the bit."""
    preset = views.scene(case)
    view = ["--scene", "s.ply", *views.view(case)]
    first = rendered(case, "a", *view, *views.walk(case.rng))
    single = ["--tracing", "single", "--k", case.rng.choice([4, 64, 1024]), "--accel", "tri20"]
    case.same(f"{preset}: rounds and one round", first, rendered(case, "b", *view, *single))


@relation()
def bound_by_opacity_agrees(case):
    """--opacity-bound on leaves the image alone, to the bit, and visits no more nodes."""
    preset = views.scene(case, presets=gaussians.PRESETS * 2 + gaussians.STRESS)
    walk = ["immediate" if option == "delayed" else option for option in views.walk(case.rng, tracing=False)]
    options = ["--scene", "s.ply", *views.view(case), *walk, "--ert", case.rng.choice(["0.001", "0.05", "0.5"])]
    images, visits = [], []
    for bound in ("off", "on"):
        images.append(rendered(case, bound, *options, "--opacity-bound", bound, "--stats", f"{bound}.json"))
        visits.append(case.json(f"{bound}.json")["stats"]["tracer.visits.total"]["value"])
    case.same(f"{preset}: with and without the bound by opacity", *images)
    if "--checkpoint-bins" not in options:  # a bin is read as a whole
        case.holds(f"{preset}: no more visits with the bound by opacity", visits[1] <= visits[0])


@relation()
def proxies_agree(case):
    """Ordered by the peak of the response, the image does not depend on the proxy, where no ray begins inside of one."""
    preset = views.scene(case, presets=["object", "building", "stress-axis", "stress-needles"])
    view = ["--scene", "s.ply", *views.view(case), "--sort-key", "peak"]
    images, inside = [], 0
    for name, accel in zip("abcd", ["tri20", "tlas-tri80", "ellipsoid", "box"]):
        case.grtx("trace", *view, "--accel", accel, "--no-trace", "--image", f"{name}.pfm", "--stats", f"{name}.json", "--quiet")
        inside += case.json(f"{name}.json")["stats"]["tracer.inside_skipped"]["value"]
        images.append(case.image(f"{name}.pfm"))
    for image in images[1:]:
        if inside == 0:
            case.same(f"{preset}: two proxies", images[0], image)
        else:
            case.holds(f"{preset}: images of two sizes", len(images[0].values) == len(image.values))


@relation()
def reference_agrees(case):
    """The image is that of brute force in fp64: 60 dB, of a stress scene 50."""
    preset = views.scene(case, presets=gaussians.PRESETS * 2 + gaussians.STRESS, most=300)
    view = views.view(case, most=16)
    case.grtx("reference", "--scene", "s.ply", *view, "-o", "r.pfm", "--quiet")
    image = rendered(case, "a", "--scene", "s.ply", *view, *views.walk(case.rng))
    case.close(f"{preset}: tracer and reference", image, case.image("r.pfm"), 50 if preset in gaussians.STRESS else 60)


def quiet_scene(case, reach=512.0, least=-8.0):
    """Rows and a camera, both on a grid: no row far away, none with a scale that is clamped."""
    views.scene(case, "raw", most=300)
    rows = [row for row in gaussians.read_ply(case.path("raw.ply")) if max(map(abs, row.place)) < reach]
    rows = [row.with_(place=[gaussians.on_grid(v) for v in row.place], scale=[max(s, least) for s in row.scale]) for row in rows]
    cameras = gaussians.read_cameras(case.path("raw.cameras.json"))
    camera = gaussians.resized(case.rng.choice(cameras), case.rng.randrange(4, 20), case.rng.randrange(4, 20))
    camera["position"] = [gaussians.on_grid(v, 2.0 ** -20) for v in camera["position"]]
    return rows, camera


def written(case, name, rows, camera):
    gaussians.write_ply(case.path(f"{name}.ply"), rows)
    gaussians.write_cameras(case.path(f"{name}.cameras.json"), [camera])
    return ["--scene", f"{name}.ply", "--cameras", f"{name}.cameras.json"]


@relation()
def exact_moves_are_exact(case):
    """Scene and camera moved, mirrored in axes and scaled by a power of two give the same image, to the bit."""
    rng = case.rng
    rows, camera = quiet_scene(case)
    power, signs = rng.choice([-4, -2, 2, 4, 8, 12]), [rng.choice([-1.0, 1.0]) for _ in range(3)]
    odd = signs[0] * signs[1] * signs[2]
    move = [math.ldexp(rng.randrange(-1 << 21, 1 << 21) * gaussians.GRID, power) for _ in range(3)]
    sh = gaussians.flipped_harmonics(signs)

    def place(vector):
        return [s * math.ldexp(v, power) + m for s, v, m in zip(signs, vector, move)]

    before, after = [], []
    for row in rows:
        scales = [gaussians.exact_scale(s, power) for s in row.scale]
        before.append(row.with_(scale=[a for a, _ in scales]))
        w, *axis = row.turn  # the turn as the mirror shows it
        after.append(row.with_(place=place(row.place), scale=[b for _, b in scales], sh=sh(row.sh),
                               turn=[w] + [odd * s * v for s, v in zip(signs, axis)]))
    # A mirrored camera has no turn that makes it: its picture is mirrored instead.
    turned = [[s * (odd * v if column == 0 else v) for column, v in enumerate(line)] for s, line in zip(signs, camera["rotation"])]
    options = [*views.shading(rng), *views.walk(rng)]
    first = rendered(case, "a", *written(case, "one", before, camera), *options)
    moved = {**camera, "position": place(camera["position"]), "rotation": turned}
    second = rendered(case, "b", *written(case, "two", after, moved), *options)
    case.same(f"moved by {move}, mirrored by {signs}, scaled by 2^{power}", first, second if odd > 0 else second.mirrored())


@relation()
def moves_are_near(case):
    """Scene and camera moved, turned and scaled by any numbers give the same image: 50 dB."""
    rng = case.rng
    rows, camera = quiet_scene(case)
    turn, factor = gaussians.random_turn(rng), 10 ** rng.uniform(-1.5, 3)
    matrix, move = gaussians.matrix_of(turn), [factor * rng.uniform(-100, 100) for _ in range(3)]
    sh = gaussians.turned_harmonics(matrix, rng)

    def place(vector):
        return [factor * v + m for v, m in zip(gaussians.applied(matrix, vector), move)]

    after = [row.with_(place=place(row.place), scale=[s + math.log(factor) for s in row.scale], sh=sh(row.sh),
                       turn=gaussians.product(turn, row.turn)) for row in rows]
    proxy = rng.choice(["icosahedron", "icosphere", "sphere"])
    options = [*views.shading(rng, proxy), *views.walk(rng, proxy)]
    first = rendered(case, "a", *written(case, "one", rows, camera), *options)
    moved = {**camera, "position": place(camera["position"]), "rotation": gaussians.times(matrix, camera["rotation"])}
    case.close(f"turned by {turn}, scaled by {factor:g}", first,
               rendered(case, "b", *written(case, "two", after, moved), *options), gaussians.ROUNDED)


@relation()
def sizes_are_one_scene(case):
    """A scene a million million times larger, or as large as the docs promise (1e37), gives the same image: 50 dB."""
    rng = case.rng
    rows, camera = quiet_scene(case, least=-6.0)
    reach = max(max(map(abs, row.place)) for row in rows) + max(max(map(abs, row.scale)) for row in rows)
    factor = 10 ** rng.uniform(3, 36 - math.log10(max(reach, 1.0)))
    after = [row.with_(place=[factor * v for v in row.place], scale=[s + math.log(factor) for s in row.scale]) for row in rows]
    proxy = rng.choice(["icosahedron", "icosphere", "sphere", "box"])
    options = views.walk(rng, proxy)
    first = rendered(case, "a", *written(case, "one", rows, camera), *options)
    moved = {**camera, "position": [factor * v for v in camera["position"]]}
    case.close(f"{proxy}, scaled by {factor:g}", first, rendered(case, "b", *written(case, "two", after, moved), *options),
               gaussians.ROUNDED)


@relation()
def rows_may_be_permuted(case):
    """Rows in another order give the same image: to the bit, but for the rays of which two hits have one distance."""
    rng = case.rng
    rows, camera = quiet_scene(case)
    # Two Gaussians in one place are two hits at one distance.
    rows = list({tuple(row.place): row for row in rows}.values())
    other = rng.sample(rows, len(rows))
    options = [*views.shading(rng), *views.walk(rng)]
    first = rendered(case, "a", *written(case, "one", rows, camera), *options)
    second = rendered(case, "b", *written(case, "two", other, camera), *options)
    pixels = range(0, len(first.values), 3)
    changed = sum(first.values[i:i + 3] != second.values[i:i + 3] for i in pixels)
    case.at_most("pixels that the order of the rows changes", changed, max(1, len(pixels) // 100))


@relation()
def objects_are_one_scene(case):
    """A scene cut into two objects, one of them moved, turned and scaled in its file and back in the list, gives its image: 50 dB."""
    rng = case.rng
    rows, camera = quiet_scene(case)
    cut = rng.randrange(1, len(rows))
    turn, factor = gaussians.random_turn(rng), 2 ** rng.uniform(-2, 2)
    if rng.random() < 0.5:
        turn = [1.0, 0.0, 0.0, 0.0]
    move = [rng.uniform(-20, 20) for _ in range(3)]
    back = [turn[0], *(-v for v in turn[1:])]
    matrix = gaussians.matrix_of(back)
    sh = gaussians.turned_harmonics(matrix, rng) if turn[0] < 1 else lambda sh: sh

    def inside(vector):  # of the world in the object's space
        return [v / factor for v in gaussians.applied(matrix, [a - b for a, b in zip(vector, move)])]

    own = [row.with_(place=inside(row.place), scale=[s - math.log(factor) for s in row.scale], sh=sh(row.sh),
                     turn=gaussians.product(back, row.turn)) for row in rows[cut:]]
    one = written(case, "one", rows, camera)
    gaussians.write_ply(case.path("first.ply"), rows[:cut])
    gaussians.write_ply(case.path("second.ply"), own)
    gaussians.write_cameras(case.path("list.json"), [{"file": "first.ply"}, {"file": "second.ply", "translate": move,
                                                                              "rotate": turn, "scale": factor}])
    walk = views.walk(rng, tracing=False)
    walk[walk.index("--accel") + 1] = "tlas-tri20"
    first = rendered(case, "a", *one, *walk)
    case.close("one scene and two objects", first, rendered(case, "b", "--scene", "list.json", *one[2:], *walk), gaussians.ROUNDED)
    if turn[0] == 1.0:  # --flatten turns no harmonics
        flat = rendered(case, "c", "--scene", "list.json", "--flatten", *one[2:], *walk)
        case.close("one scene and two objects, flattened", first, flat, gaussians.ROUNDED)


@relation()
def quadrants_are_the_frame(case):
    """Four cameras, each of a quarter of the frame, give the pixels of the frame, to the bit."""
    rng = case.rng
    preset = views.scene(case, presets=gaussians.PRESETS + gaussians.STRESS)
    cameras = gaussians.read_cameras(case.path("s.cameras.json"))
    frame = gaussians.resized(rng.choice(cameras), 2 * rng.randrange(2, 11), 2 * rng.randrange(2, 11))
    width, height = frame["width"] // 2, frame["height"] // 2
    quarters = [{**frame, "width": width, "height": height, "cx": frame["cx"] - x * width, "cy": frame["cy"] - y * height}
                for y in range(2) for x in range(2)]
    gaussians.write_cameras(case.path("quarters.json"), [frame, *quarters])
    options = ["--scene", "s.ply", "--cameras", "quarters.json", *views.shading(rng)]
    whole = rendered(case, "a", *options, *views.walk(rng))
    walk = views.walk(rng)
    parts = [rendered(case, f"q{i}", *options, *walk, "--view", i + 1) for i in range(4)]
    put = [v for y in range(2 * height) for x in range(2 * width)
           for v in parts[y // height * 2 + x // width].pixel(x % width, y % height)]
    case.same(f"{preset}: frame and quarters", list(whole.values), put)


@relation()
def sequences_are_their_views(case):
    """The frames of --views A:B are the images of the views by themselves, to the bit."""
    preset = views.scene(case)
    options = ["--scene", "s.ply", "--cameras", "s.cameras.json", *views.size(case.rng), *views.walk(case.rng, tracing=False)]
    case.grtx("trace", *options, "--views", "0:1", "-o", "a.grtx", "--image", "a.pfm", "--quiet")
    for number in range(2):
        frame = case.image(f"a_{number}.pfm")
        case.same(f"{preset}: frame {number}", frame, rendered(case, f"b{number}", *options, "--view", number))

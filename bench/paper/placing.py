# SPDX-License-Identifier: Apache-2.0
"""Cameras of a sequence, and objects placed before a camera. Cameras are entries of a 3DGS cameras.json: rotation has the
camera's right, down and forward axes as columns."""
import math


def columns(camera):
    return [[row[i] for row in camera["rotation"]] for i in range(3)]


def panned(camera, degrees):
    """The same camera, turned about its own vertical axis."""
    right, down, forward = columns(camera)
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    turned = [[c * r - s * f for r, f in zip(right, forward)], down, [s * r + c * f for r, f in zip(right, forward)]]
    return {**camera, "rotation": [list(row) for row in zip(*turned)]}


def sequence(camera, degrees, frames):
    """Cameras of a sequence that turns by so many degrees a frame."""
    return [{**panned(camera, degrees * i), "id": i, "img_name": f"frame_{i}"} for i in range(frames)]


def ring(camera, room, statue, count, turn, distance=1.6, radius=0.6, scale=0.25):
    """An object list: the room, and `count` placements of the statue in a ring before the camera, moved on by `turn` degrees. They
    are not turned themselves, so that the list can be flattened with its spherical harmonics."""
    forward = columns(camera)[2]
    centre = [p + distance * f for p, f in zip(camera["position"], forward)]
    placed = [{"file": room}]
    for i in range(count):
        angle = math.radians(turn + 360.0 * i / count)
        placed.append({"file": statue, "scale": scale,
                       "translate": [centre[0] + radius * math.cos(angle), centre[1], centre[2] + radius * math.sin(angle)]})
    return placed

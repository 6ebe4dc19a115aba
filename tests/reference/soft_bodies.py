"""Twin of effect `soft_bodies`: rays against the triangles of two instants.

A shown pixel's place on its triangle says where the late picture had it.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from hmdwarp.geometry import View
from reference._rays import Array, world_directions
from reference.raycast import cast_triangles
from reference.relight import FLOOR, Relit, _lights


@attrs.frozen(eq=False)
class SoftAsked:
    """What the pass goes by; pictures (h, w, ..) bottom row first.

    then, now: (m, 3, 3) corners in the world; albedo, baked: (m, 3, 3) of the corners. picture,
    depth: what is shown before. late, late_depth: the late picture. constants: the uniforms of
    soft_light.comp and relight_blocks.comp by name. offsets: (n, 2) whole pixels.
    """

    then: Array
    now: Array
    albedo: Array
    baked: Array
    picture: Array
    depth: Array
    shown: View
    late: Array
    late_depth: Array
    late_view: View
    offsets: NDArray[np.integer]
    constants: dict[str, float]


def _met(corners: Array, view: View, size: tuple[int, int]) -> tuple[Array, Array, Array]:
    """(n) inverse depth, -1 for nothing; (n) which triangle; (n, 3) weights of its corners."""
    hits = cast_triangles(corners, view.pose.position_m, world_directions(view, size).reshape(-1, 3))
    weights = np.concatenate([1 - hits.uv.sum(axis=1, keepdims=True), hits.uv], axis=1)
    return np.where(hits.shape >= 0, hits.inverse_depth, -1.0), hits.shape, weights


def _on(values: Array, which: Array, weights: Array) -> Array:
    return np.einsum("nk,nkc->nc", weights, values[which])


def soft_bodies(asked: SoftAsked) -> tuple[Array, Array]:
    """(h, w, 4) colour and (h, w) inverse depth."""
    (high, wide), (late_high, late_wide) = asked.depth.shape, asked.late_depth.shape
    body_then, which_then, weights_then = _met(asked.then, asked.late_view, (late_wide, late_high))
    albedo_then = np.where(body_then[:, None] >= 0, _on(asked.albedo, which_then, weights_then), -1.0)
    body_then = body_then.reshape(late_high, late_wide)
    albedo_then = albedo_then.reshape(late_high, late_wide, 3)
    body, which, weights = _met(asked.now, asked.shown, (wide, high))
    drawn = (body >= 0) & (asked.depth.ravel() <= body * (1 + asked.constants["same"]))
    colour, depth = asked.picture.reshape(-1, 4).copy(), asked.depth.ravel().copy()
    into_late = asked.late_view.pose.rotation.as_matrix()
    lights = _lights(
        Relit(
            asked.late_view.fov, asked.late, asked.late_depth, albedo_then, albedo_then, body_then, asked.offsets,
            int(asked.constants["block"]), asked.constants["same_depth"], asked.constants["same_surface"],
            asked.constants["near"], asked.constants["off_plane"], asked.constants["model_weight"],
        )
    )  # fmt: skip
    rays = world_directions(asked.shown, (wide, high)).reshape(-1, 3)
    for n in np.flatnonzero(drawn):
        own, baked = (_on(values, which[[n]], weights[[n]])[0] for values in (asked.albedo, asked.baked))
        place = (weights[n] @ asked.then[which[n]] - asked.late_view.pose.position_m) @ into_late
        a, b, c = asked.now[which[n]]
        side = np.sign(np.cross(b - a, c - a) @ rays[n])
        a, b, c = asked.then[which[n]]
        away = side * np.cross(b - a, c - a) @ into_late
        colour[n] = *_lit(asked, place, away / np.linalg.norm(away), own, baked, (body_then, albedo_then), lights), 1
        depth[n] = body[n]
    return colour.reshape(high, wide, 4), depth.reshape(high, wide)


def _lit(asked: SoftAsked, place: Array, away: Array, own: Array, baked: Array, then: tuple, lights) -> Array:
    body_then, albedo_then = then
    high, wide = body_then.shape
    if place[2] > -asked.constants["nearest"]:
        return baked
    r = -1 / place[2]
    left, right, down, up = asked.late_view.fov.tangents
    at = (place[:2] * r - (left, down)) / (right - left, up - down) * (wide, high)
    seen, plain, total = np.zeros(3), np.zeros(3), 0.0
    for y in (int(np.floor(at[1] - 0.5)), int(np.floor(at[1] - 0.5)) + 1):
        for x in (int(np.floor(at[0] - 0.5)), int(np.floor(at[0] - 0.5)) + 1):
            if not (0 <= x < wide and 0 <= y < high) or away @ place <= 0:
                continue
            b = body_then[y, x]
            shows = b >= 0 and asked.late_depth[y, x] <= b * (1 + asked.constants["same"])
            if shows and abs(b - r) <= asked.constants["steepest"] * r:
                weight = (1 - abs(x + 0.5 - at[0])) * (1 - abs(y + 0.5 - at[1]))
                seen, plain = seen + weight * asked.late[y, x, :3], plain + weight * albedo_then[y, x]
                total += weight
    if total >= asked.constants["least"]:
        black = asked.constants["black"] * total
        return (own * seen + black * baked) / (plain + black)
    seen, plain = np.zeros(3), np.zeros(3)
    point = place * r / (r + FLOOR)
    for x, y in np.floor(at).astype(int) + asked.offsets:
        if 0 <= x < wide and 0 <= y < high:
            block = y // int(asked.constants["block"]), x // int(asked.constants["block"])
            way = (lights.point[block] - point) * (r + FLOOR)
            distance, off = np.linalg.norm(way) / asked.constants["near"], way @ away / asked.constants["off_plane"]
            weight = max(away @ lights.normal[block], 0) ** 4 / (1 + distance**2) ** 2 / (1 + off**2)
            seen, plain = seen + weight * lights.seen[block], plain + weight * lights.plain[block]
    share = asked.constants["model_weight"]
    return (own * seen + share * baked) / (plain + share)

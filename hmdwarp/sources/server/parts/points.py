"""Points of what the head may see, as densely as its pixels need them, and only once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....frames.layers.points import (
    HEAD_BYTES,
    POINT_BYTES,
    SKY_BYTES,
    Block,
    Cloud,
    PointSender,
    PointUpdate,
    Sent,
    block_range,
    packed_sky,
)
from ....geometry import View
from ....gpu.textures import download, flip_rows
from ....scenes import PointCells
from . import DrawContext, Drawing, parts
from ._sending import FIRST_ROUND_TRIP_NS, NEAREST_M, Head, Sending, boxes_at, distances, may_be_seen

Array = NDArray[np.float64]
# What the head does not see yet gets points of this share of the density, with what is left.
AHEAD = 1 / 16
_MOST_POINTS = 1 << 16  # of a cell
# What hides what is looked up in a picture of so many pixels a side. A cell counts as hidden if it
# lies behind all within so many of its own pixels at its middle and around it; one that looks
# larger than that never does.
HIDING, AROUND = 96, 5


@parts.register
class Points(Sending[Cloud, "_Sender"]):
    """One sender for each Cloud that frames need."""

    name = "points"
    order = 201

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._head = Head()

    def make_sender(self, wanted: Cloud) -> _Sender:
        return _Sender(_cells_of(self.context.scene), wanted)

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        needed = self.needed(drawing)
        if not needed:
            return {}
        self._head.see(views[0], drawing.time_ns)
        left, right, *_ = drawing.view.fov.tangents
        pixel = (right - left) / (drawing.shown_size or drawing.size)[0]
        nearest = [self._farthest_around(view, drawing.time_ns) for view in views]
        updates = {
            cloud: self.sender(cloud).update(views, nearest, self._head, pixel, drawing.time_ns) for cloud in needed
        }
        return {"points": updates}

    def _farthest_around(self, view: View, time_ns: int) -> Array:
        """Return the least inverse depth around each pixel of a small picture, bottom row first."""
        from scipy.ndimage import minimum_filter

        hiding = self.kept("hiding", (HIDING, HIDING))
        self.context.colour.draw(view, self.context.framebuffers.over(hiding.colour, hiding.inverse_depth), time_ns)
        least: Array = minimum_filter(flip_rows(download(hiding.inverse_depth)), AROUND, mode="nearest")
        return least


# One object for a scene: clients share what takes longest to make.
_cells_of = lru_cache(maxsize=2)(PointCells)


class _Sender:
    """What one Cloud still lacks, and in which order it is sent."""

    def __init__(self, cells: PointCells, cloud: Cloud) -> None:
        self._cells, self._cloud = cells, cloud
        self.book = PointSender(cells.count, cloud.room)
        # When each cell was last requested, by number of update.
        self._wanted_at = np.zeros(cells.count, np.int64)
        self._updates = 0
        # Whether nothing that may be seen waits to be sent.
        self._complete = False

    def has_more(self, now_ns: int) -> bool:
        """Return whether points wait to be sent."""
        return not self._complete

    def update(
        self, views: Sequence[View], nearest: Sequence[Array], head: Head, pixel: float, now_ns: int
    ) -> PointUpdate:
        """Return what a frame drawn now brings.

        nearest: what hides the rest, for each view. pixel: its size at a distance of 1.
        """
        self.book.settle(now_ns)
        self._updates += 1
        spacing, seen, shown, looks = self._needs(views, nearest, head, pixel, now_ns)
        self._wanted_at[seen] = self._updates
        need = np.minimum(self._cells.area / spacing**2, _MOST_POINTS)
        # First come notes of what is forgotten: half of the bytes at most.
        sent = self.book.forgetting(self._cloud.budget // (2 * HEAD_BYTES))
        left = self._cloud.budget - SKY_BYTES - HEAD_BYTES * len(sent)
        for who, share in ((shown, 1.0), (seen & ~shown, 1.0), (~seen, AHEAD)):
            more, left = self._send(np.where(who, share * need, 0), looks, left, may_forget=who is shown)
            sent += more
        lacks = shown & (self.book.points < need)
        self._complete = not lacks.any()
        content = b"".join(self._block(block, spacing).packed() for block in sent)
        background = self._cells.scene.background
        sky = packed_sky(np.array([background.zenith, background.horizon, background.ground]), complete=self._complete)
        return PointUpdate(np.frombuffer(sky + content, np.uint8).copy(), tuple(sent), now_ns)

    def _send(self, wanted: Array, looks: Array, left: int, *, may_forget: bool) -> tuple[list[Sent], int]:
        """Enter blocks of cells that lack points as sent; return them, and bytes left.

        looks: how large each cell looks; first go those whose points lie farthest apart.
        """
        book = self.book
        out: list[Sent] = []
        while True:
            lacks = np.flatnonzero(book.points < wanted)
            apart = looks[lacks] / np.maximum(book.points[lacks], 0.1)
            for cell in lacks[np.argsort(-apart, kind="stable")].tolist():
                count = block_range(book.next_block(cell))[1]
                size = HEAD_BYTES + POINT_BYTES * count
                if size > left:
                    return out, left
                if count > book.free:
                    if may_forget:
                        self._make_room()
                    return out, left
                out.append(book.sent(cell))
                left -= size
            if not len(lacks) or left <= 0:
                return out, left

    def _make_room(self) -> None:
        """Forget what has not been seen for longest: an eighth of the room."""
        held = np.flatnonzero((self.book.points > 0) & (self._wanted_at < self._updates))
        freed = 0
        for cell in held[np.argsort(self._wanted_at[held], kind="stable")].tolist():
            if freed >= self._cloud.room // 8:
                break
            freed += int(self.book.points[cell])
            self.book.forget(cell)

    def _needs(
        self, views: Sequence[View], nearest: Sequence[Array], head: Head, pixel: float, now_ns: int
    ) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_], Array]:
        """Return how far apart each cell's points may lie, in metres, and which may be seen.

        Then which of them nothing hides now, and the solid angle of each. Seen from any place that
        the head can reach until the news of this frame returns.
        """
        cells = self._cells
        origin = cells.scene.origin_m
        centres, halves = boxes_at(cells.scene, cells.body, cells.centres, cells.halves, now_ns)
        facing = cells.facing.copy()
        for number in set(cells.body.tolist()) - {0}:
            own = cells.body == number
            turn = cells.scene.bodies[number - 1].motion.state(now_ns).pose.matrix()[:3, :3]
            facing[own] = facing[own] @ turn.T
        metres, radians = head.reach(self.book.round_trip_ns or FIRST_ROUND_TRIP_NS)
        eye = np.mean([view.pose.position_m for view in views], axis=0) - origin
        away = distances(eye, centres, halves) - metres
        seen = np.zeros(cells.count, bool)
        for view in views:
            seen |= may_be_seen(centres, halves, view, origin, metres, radians)
        # A cell turns its back if all places of the head are behind the planes of all triangles.
        to_eye = eye - centres
        slack = np.linalg.norm(halves, axis=1) + metres
        distance = np.linalg.norm(to_eye, axis=1)
        cosine = np.einsum("ij,ij->i", to_eye, facing) / np.maximum(distance, 1e-9)
        spread = np.arccos(np.clip(cells.least_cosine, -1, 1)) + np.arcsin(
            np.clip(slack / np.maximum(distance, 1e-9), 0, 1)
        )
        turned = (np.arccos(np.clip(cosine, -1, 1)) - spread > np.pi / 2) & ~cells.double_sided
        seen &= ~turned
        hidden = np.ones(cells.count, bool)
        for view, one in zip(views, nearest, strict=True):
            hidden &= _hidden(centres - (view.pose.position_m - origin), np.linalg.norm(halves, axis=1), view, one)
        looks = cells.area * np.maximum(np.abs(cosine), 0.05) / np.maximum(distance, NEAREST_M) ** 2
        return pixel * self._cloud.spacing * np.maximum(away, NEAREST_M), seen, seen & ~hidden, looks

    def _block(self, sent: Sent, spacing: Array) -> Block:
        cell, age, number = sent
        cells = self._cells
        first, count = block_range(number) if number >= 0 else (0, 0)
        # Closer than a pixel, each has the mean of a pixel: the texture between them is not seen.
        apart = float(spacing[cell]) * max(1.0, 1 / self._cloud.spacing)
        points = cells.points(cell, first, count, apart)
        low = tuple(cells.low[cell].tolist())
        return Block(
            cell, age, number, int(cells.body[cell]), bool(cells.double_sided[cell]), low,
            float(cells.edge[cell]), float(cells.area[cell]), points.positions, points.normals, points.colours,
        )  # fmt: skip


def _hidden(offsets: Array, radii: Array, view: View, nearest: Array) -> NDArray[np.bool_]:
    """Return which balls, at offsets from the eye, lie behind all that is around their middle.

    nearest: (h, w) the least inverse depth around each pixel. What lies outside is not hidden.
    """
    height, width = nearest.shape
    eye = offsets @ view.pose.rotation_matrix
    left, right, down, up = view.fov.tangents
    depth = np.maximum(-eye[:, 2], NEAREST_M)
    at = np.column_stack([(eye[:, 0] / depth - left) / (right - left), (eye[:, 1] / depth - down) / (up - down)])
    inside = (-eye[:, 2] > radii) & ((at >= 0) & (at < 1)).all(axis=1)
    small = radii / depth * max(width / (right - left), height / (up - down)) < AROUND / 2
    column, row = (at.clip(0, 0.999999) * (width, height)).astype(int).T
    hidden: NDArray[np.bool_] = inside & small & (nearest[row, column] * np.maximum(depth - radii, NEAREST_M) > 1)
    return hidden

"""Points of a scene's surfaces under lamps, against the light of each point itself."""

from __future__ import annotations

import numpy as np
import pytest
from lit_rooms import plain

from hmdwarp.cloudlight.points import PointCells
from hmdwarp.cloudlight.radiosity import direct_light, transport_of
from hmdwarp.colour import linear_from_srgb
from hmdwarp.scenes import lamps_at, load_scene


@pytest.mark.parametrize("name", ["lantern", "sunroom", "doorway"])
def test_points_have_the_light_of_the_start(name):
    """Light at corners 25 cm apart is blended: half of all points lie where it is smooth within a
    tenth. Nearly none has the bare albedo, which is what points had before."""
    scene = plain(load_scene(name))
    cells, transport = PointCells(scene), transport_of(scene)
    lamps = lamps_at(scene, 0)
    atlas = transport.indirect(transport.direct(lamps))
    errors = []
    for cell in range(0, cells.count, 7):
        found = cells.block((cell, 0, 0), 0.01)
        steps = np.stack([found.positions >> (10 * k) & 1023 for k in range(3)], axis=1) / 1023
        places, body = cells.low[cell] + cells.edge[cell] * steps, cells.body[cell]
        facing = np.tile(cells.facing[cell], (len(places), 1))
        if body:
            pose = scene.bodies[body - 1].motion.state(0).pose
            places, facing = pose.transform(places), pose.rotation.apply(facing)
        near = ((transport.patches.centres - places[:, None]) ** 2).sum(axis=2)
        near += 1e3 * (transport.patches.normals @ facing.T < 0.99).T
        patch = near.argmin(axis=1)
        light = direct_light(transport.blockers, places + 2e-3 * facing, facing, lamps) + atlas[patch]
        wanted = np.minimum(transport.patches.albedo[patch] * light, 1)
        errors.append(
            np.abs(linear_from_srgb(found.colours) - wanted).mean(axis=1) / np.maximum(wanted.mean(axis=1), 0.01)
        )
    assert np.median(np.concatenate(errors)) < 0.1

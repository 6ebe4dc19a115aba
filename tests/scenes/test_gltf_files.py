"""Scenes of files: what is read of each small one in `files/`, or with what it is refused.

`files.toml` has the options of some, `files.txt` what was read. A new file is added as it is;
after an intended change look at what differs, then write it:

    HMDWARP_GOLDEN=write .venv/bin/python -m pytest tests/scenes/test_gltf_files.py
"""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from hmdwarp.base import InputError
from hmdwarp.client.effects import effects
from hmdwarp.scenes import Mesh, Scene, SceneOptions, is_cutout, load_scene

from .glb import IN_PLACE

FILES = Path(__file__).parent / "files"
GOLDEN = FILES.with_suffix(".txt")
STATED = tomllib.loads(FILES.with_suffix(".toml").read_text(encoding="utf-8"))
NAMES = sorted(path.name for path in FILES.iterdir() if path.suffix not in (".mtl", ".png", ".serialized"))
NUMBER = re.compile(r"-?\d+\.\d+")
AT_NS = (0, 300_000_000, 1_100_000_000, 2_700_000_000)


def written(*arrays: object) -> str:
    """Each row of numbers, or of a long list what is in the middle and how far it reaches."""
    found = []
    for array in arrays:
        rows = np.atleast_2d(np.asarray(array, float))
        rows = rows if len(rows) <= 12 else np.stack([rows.mean(axis=0), np.ptp(rows, axis=0)])
        found.append(" ".join("(" + " ".join(f"{x + 0.0:.5f}" for x in row) + ")" for row in rows))
    return "; ".join(found)


def told_of(mesh: Mesh, scene: Scene) -> list[str]:
    at = mesh.positions if mesh.body or mesh.material.head_locked else mesh.positions + scene.origin_m
    lines = [f"mesh {mesh.name}: body {mesh.body}, texture {mesh.texture}, cut out {is_cutout(scene, mesh)}"]
    lines += [f"  {mesh.material}", f"  triangles {mesh.triangles[:12].tolist()}, two sides {mesh.double_sided}"]
    lines += [f"  at {written(at)}", f"  normals {written(mesh.normals)}", f"  uv {written(mesh.uv)}"]
    lines += [f"  light {written(mesh.light)}"]
    for name in ("albedo", "light_uv"):
        if (rows := getattr(mesh, name)) is not None:
            lines += [f"  {name} {written(rows)}"]
    moves = mesh.deformation
    if moves is not None:
        lines += [f"  moves {written(moves.positions(ns) + scene.origin_m, moves.velocities(ns))}" for ns in AT_NS]
    return lines


def told(scene: Scene) -> str:
    """All of a scene that a file may change, a line each."""
    lines = [f"effects {effects.of(scene)}", *(f"note: {note}" for note in scene.notes)]
    lines += [f"seen from {written(scene.viewpoint.position_m)}, walks {written(*scene.walk_bounds_m)}"]
    for mesh in scene.meshes:
        lines += told_of(mesh, scene)
    for texture in scene.textures:
        image = texture.image.reshape(-1, texture.image.shape[-1])
        lines += [f"texture: {texture.image.shape}, repeats {texture.repeat}, sRGB {texture.srgb}"]
        lines += [f"  bytes {written(image)}, emission {texture.emission is not None}"]
    for body in scene.bodies:
        states = [body.motion.state(ns) for ns in AT_NS]
        lines += [f"body {body.name}"]
        for state in states:
            turn = state.pose.rotation.as_rotvec()
            lines += [f"  {written(state.pose.position_m, turn, state.velocity_m_s, state.angular_velocity_rad_s)}"]
    for lamp in scene.lamps:
        lines += [f"lamp: sun {lamp.is_sun}, cone {lamp.cone}, {written(lamp.colour, *map(lamp.place, AT_NS))}"]
    for panel in scene.panels:
        lines += [f"panel: locked {panel.head_locked}, occluded {panel.occluded}, {panel.pictures[0].image.shape}"]
        lines += [f"  {written(panel.pose.position_m, panel.pose.rotation.as_rotvec(), panel.size_m)}"]
    for mirror in scene.mirrors:
        shape = mirror.shape
        lines += [f"mirror: curved {shape.is_curved}, normals {mirror.normal_scale}, {written(shape.centre_m)}"]
    return "\n".join(lines)


@pytest.mark.parametrize("name", NAMES)
def test_a_file_is_read_or_refused_as_it_was(name):
    options = SceneOptions(**STATED[name]) if name in STATED else IN_PLACE
    try:
        text = told(load_scene(FILES / name, options))
    except InputError as error:
        text = f"refused: {str(error).replace(str(FILES), '')}"
        assert "\n" not in str(error)
    begins = f"# {name}\n"
    if os.environ.get("HMDWARP_GOLDEN") == "write":
        before = GOLDEN.read_text(encoding="utf-8") if name != NAMES[0] else ""
        GOLDEN.write_text(f"{before}{begins}{text}\n\n", encoding="utf-8")
    was = GOLDEN.read_text(encoding="utf-8").partition(begins)[2].partition("\n\n# ")[0].rstrip("\n")
    assert NUMBER.sub("#", text) == NUMBER.sub("#", was), "see the top of this file"
    # Numbers are float32 of at most some metres, written to five decimals.
    now, then = (np.array(NUMBER.findall(words), float) for words in (text, was))
    assert np.allclose(now, then, rtol=1e-4, atol=1e-4), "see the top of this file"

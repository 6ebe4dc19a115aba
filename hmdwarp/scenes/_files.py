"""A user's glTF, OBJ, PLY or Mitsuba file as a scene: colours kept, a plain light baked in."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import HmdwarpError, InputError, SceneError
from ..base.named_files import SCENE, opened
from ..geometry import Pose
from ._draft import Draft, Notes
from ._gltf_scene import GltfContent
from ._lamps import lit_by
from ._mesh import Body, Texture
from ._mesh_files import drafts_of, mitsuba_drafts, unreadable
from ._scene import Background, Scene
from ._viewpoint import EYE_HEIGHT_M, Place, Triangles, add_hints, free_place, is_inside, place_at
from .options import FILE_ENDINGS, SceneOptions

Array = NDArray[np.float64]
Content = GltfContent | None  # of a glTF file
SKY = Background((0.30, 0.42, 0.62), (0.72, 0.77, 0.82), (0.32, 0.31, 0.30))
# The head at rest: where traces are made, a window's viewer begins and OpenXR has its stage.
STANDING = np.array([0.0, EYE_HEIGHT_M, 0.0])
LARGEST_M = 1e9  # of a scene: beyond it squares of distances and inverse depths leave float32
_FROM_Z_UP = ((1, 0, 0), (0, 0, 1), (0, -1, 0))


def scene_from_file(path: Path, options: SceneOptions) -> Scene:
    """Return the file's triangles as a Scene; its notes say what was left out or replaced.

    The viewer's place is at (0, 1.6, 0), looking along -z; the origin is kept apart in float64
    (origin_m), so that far from it no digits are lost on the GPU. Errors: SceneError, one line, for
    a file that cannot be used; InputError for a camera or an animation that it lacks.
    """
    with opened(path, attrs.evolve(SCENE, what=f"{SCENE.what}, or the name of a scene")) as file:
        if not file.read(1):
            raise SceneError(f"{path}: the file is empty; expected {SCENE.what}")
    if path.suffix.lower() not in FILE_ENDINGS:
        raise SceneError(f"{path}: cannot read '{path.suffix}' scenes; expected {SCENE.what}: export it as .glb")
    notes, units = Notes(path), np.eye(4)  # from the file's world to metres with +y up
    units[:3, :3] = options.scale * np.array([(1, 0, 0), (0, 1, 0), (0, 0, 1)] if options.up == "y" else _FROM_Z_UP)
    content, textures = None, list[Texture]()
    try:
        with np.errstate(all="ignore"):
            if path.suffix.lower() in (".glb", ".gltf"):
                content = GltfContent(path, units, options.animation, notes)
                drafts, textures = content.drafts, content.textures
            elif options.animation is not None:
                raise InputError(f"--animation '{options.animation}': only glTF files have animations; leave it out")
            else:
                read = mitsuba_drafts if path.suffix.lower() == ".xml" else drafts_of
                drafts = read(path, units, notes, textures)
                taken = ["a unit is a metre (--scene-scale)"] * (options.scale == 1)
                if taken := taken + ["y is up (--scene-up)"] * (options.up == "y"):
                    notes.add(f"assumed (not stated in the file): {', '.join(taken)}")
            return _put(drafts, path, options, notes, textures, content)
    except (HmdwarpError, MemoryError):
        raise
    except Exception as error:  # a damaged file may hold any value where another is due
        raise unreadable(path, error) from error


def _put(
    drafts: Sequence[Draft], path: Path, options: SceneOptions, notes: Notes, textures: list[Texture], content: Content
) -> Scene:
    """Return the scene of these drafts, put where the viewer stands."""
    if not drafts:
        what = f"{path}: no triangles in it; expected a mesh, not points, lines or an empty scene"
        raise SceneError(f"{what}: make a surface of the points, or export the scene with its meshes")
    standing = [draft for draft in drafts if not draft.look.material.head_locked]
    clouds = [draft.positions for draft in standing] or [np.array([STANDING - 1, STANDING + 1])]
    low = np.array([points.min(axis=0) for points in clouds]).min(axis=0)
    high = np.array([points.max(axis=0) for points in clouds]).max(axis=0)
    if not (high - low).any():
        raise SceneError(f"{path}: all {sum(map(len, clouds))} positions are the same point; export it again")
    if (size := float((high - low).max())) > LARGEST_M:
        what = f"{path}: {size:.3g} m across; expected at most {LARGEST_M:.0e} m"
        raise SceneError(f"{what}: say what its unit is by --scene-scale, or export it again")
    solid = [draft for draft in standing if draft.is_surface] or standing
    triangles = Triangles.of([(draft.positions, draft.triangles) for draft in solid])
    add_hints(size, options.scale, notes)
    place = _place(options, notes, triangles, low, high, content)
    half = np.radians(place.yaw_deg) / 2  # a head at rest is there
    world_from_file = Pose(STANDING) @ Pose(place.eye, (0.0, np.sin(half), 0.0, np.cos(half))).inverse()
    if content is not None:
        content.move(world_from_file)
    bodies: Sequence[Body] = content.bodies if content is not None else ()
    corners = world_from_file.transform(np.array([low, high]))
    origin = np.round(corners.mean(axis=0))  # whole metres, so that a scene near the origin keeps its own numbers
    panels = [draft.as_panel(world_from_file, textures) for draft in drafts if draft.panel]
    drafts = [draft for draft in drafts if not draft.panel]
    meshes = [draft.mesh(world_from_file, origin, bodies) for draft in drafts]
    lamps = content.lamps() if content is not None else []
    if lamps:
        looks = [(draft.look, draft.is_surface and draft.driven is None) for draft in drafts]
        lit = [is_rigid and not look.unlit and not look.emission.any() for look, is_rigid in looks]
        meshes, lamps = lit_by(lamps, meshes, lit, textures, origin, notes)
    name = path.resolve().parent.name if path.name.lower() == "scene.xml" else path.stem
    summary = f"{path.name}: {sum(len(mesh.triangles) for mesh in meshes)} triangles"
    sky = Background() if lamps else SKY  # lamps are all the light that a file has
    where: dict[str, Any] = {"viewpoint": Pose(STANDING), "walk_bounds_m": STANDING + place.reach, "origin_m": origin}
    found: dict[str, Any] = {"notes": notes.lines(), "lamps": lamps, "panels": panels}
    return Scene(name, summary, meshes, textures, sky, bodies, **where, **found)


def _place(
    options: SceneOptions, notes: Notes, triangles: Triangles, low: Array, high: Array, content: Content
) -> Place:
    cameras = [] if content is None else [name for name, _ in content.cameras]
    if options.viewpoint is None:
        found = free_place(triangles, low, high)
        if cameras:
            most = ", ".join(f"'{name}'" for name in cameras[:8]) + (" and more" if len(cameras) > 8 else "")
            notes.add(f"has cameras: {most}; --viewpoint NAME takes one")
        if found.yaw_deg or np.abs(found.eye - STANDING).max() > 1e-9:
            text = ",".join(f"{value:.4g}" for value in (*found.eye, *([found.yaw_deg] if found.yaw_deg else [])))
            notes.add(f"seen from {text} of the file, which is at (0, 1.6, 0) here; --viewpoint changes that")
        return found
    numbers = options.place
    if numbers is None:
        if content is None:
            raise InputError(f"--viewpoint '{options.viewpoint}': only glTF files have cameras; give X,Y,Z[,YAW]")
        numbers = content.camera(options.viewpoint)
    eye, yaw = np.array(numbers[:3]), numbers[3]
    if is_inside(triangles, eye):
        notes.add(f"the viewpoint {options.viewpoint} lies inside an object")
    elif np.linalg.norm(np.maximum(0, np.maximum(low - eye, eye - high))) > max(2 * float((high - low).max()), 3):
        notes.add(f"the viewpoint {options.viewpoint} lies far outside the scene, which is hardly seen from there")
    return place_at(triangles, eye, yaw, high - low)

# Shows: a renderer in Python (NumPy rays, trimesh meshes), replayed over a real connection.
# Writes: replay (a replay's folder)

import sys
from pathlib import Path

import numpy as np
import trimesh

import hmdwarp

things = [
    (trimesh.creation.box((8, 0.1, 8)).apply_translation((0, -0.05, -2)), (0.20, 0.18, 0.15)),  # the floor
    (trimesh.creation.icosphere(subdivisions=1, radius=0.4).apply_translation((-0.6, 1.4, -2)), (0.60, 0.05, 0.02)),
    (trimesh.creation.box((0.6, 1.2, 0.6)).apply_translation((0.6, 0.6, -2.5)), (0.03, 0.10, 0.60)),
]
corners = np.concatenate([mesh.triangles for mesh, _ in things])  # (n, 3 corners, 3), world, y up
normals = np.concatenate([mesh.face_normals for mesh, _ in things])
paints = np.concatenate([np.tile(paint, (len(mesh.faces), 1)) for mesh, paint in things])


def trace(view, size):
    """Return linear light (h, w, 3) and metres along -z (h, w), row 0 at the top."""
    rays = view.rays(size)[::-1] @ view.pose.rotation_matrix.T  # as z is -1 in the eye, their factor is the depth
    rays, (a, b, c) = rays.reshape(-1, 3), (corners - view.pose.position_m).swapaxes(0, 1)
    beside = np.stack([rays @ np.cross(*edge).T for edge in ((a, b), (b, c), (c, a))])
    with np.errstate(divide="ignore", invalid="ignore"):
        depth_m = (a * normals).sum(axis=1) / (rays @ normals.T)
    depth_m[~((beside > 0).all(axis=0) | (beside < 0).all(axis=0)) | ~(depth_m > 0)] = np.inf
    nearest, depth_m = depth_m.argmin(axis=1), depth_m.min(axis=1)
    light = paints[nearest] * (0.4 + 0.6 * np.abs(normals[nearest] @ (0.5, 0.8, 0.33)))[:, None]
    colour = np.where(np.isfinite(depth_m)[:, None], light, (0.25, 0.45, 0.75))
    return colour.reshape(*size[::-1], 3), depth_m.reshape(size[::-1])


def render(views, time_ns):
    """Return what each eye sees; on its own: hmdwarp.feed.serve(render, "127.0.0.1:5570")."""
    return zip(*(trace(view, views.size) for view in views), strict=True)


out = Path(sys.argv[1] if len(sys.argv) > 1 else "out/python_renderer")
run = {"trace": "look-around", "scene": "server", "size": (96, 120), "seconds": 0.5, "out": out / "replay"}
run |= {"headset": "rift-dk1"}
with hmdwarp.feed.serving(render) as address:
    print(hmdwarp.replay(hmdwarp.RunOptions(feed=hmdwarp.feed.FeedOptions(connect=address), **run)))

# Shows: a scene of your own, made with trimesh and saved as GLB, replayed with a recorded head.
# Writes: scene.glb, replay/summary.json, replay/report.html

import sys
from pathlib import Path

import trimesh
from trimesh.visual.material import PBRMaterial

import hmdwarp

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out/scene_from_glb")
out.mkdir(parents=True, exist_ok=True)


def painted(mesh: trimesh.Trimesh, red: int, green: int, blue: int, x: float, y: float, z: float) -> trimesh.Trimesh:
    """Return the mesh in one colour, moved to (x, y, z): metres, y up, the head looks along -z."""
    mesh.visual = trimesh.visual.TextureVisuals(material=PBRMaterial(baseColorFactor=[red, green, blue, 255]))
    return mesh.apply_translation((x, y, z))


scene = trimesh.Scene(
    [
        painted(trimesh.creation.box((8, 0.1, 8)), 120, 110, 100, 0, -0.05, 0),  # the floor
        painted(trimesh.creation.icosphere(radius=0.4), 200, 60, 40, -0.6, 1.4, -2),
        painted(trimesh.creation.box((0.6, 1.2, 0.6)), 40, 90, 200, 0.6, 0.6, -2.5),
        painted(trimesh.creation.box((0.3, 2.5, 0.3)), 90, 160, 70, 0.0, 1.25, -3.5),
    ]
)
scene.export(out / "scene.glb")

options = hmdwarp.RunOptions(
    trace="look-around",
    scene=str(out / "scene.glb"),
    as_recorded=True,
    headset="rift-dk1",
    size=(96, 120),
    seconds=0.3,
    out=out / "replay",
)
summary = hmdwarp.replay(options).summary
print(f"{summary['scene']}: FLIP {summary['quality']['flip']['mean']:.3f}")

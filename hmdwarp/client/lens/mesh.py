"""A lens by the tangents at the points of a grid over the panel, for each channel."""

from __future__ import annotations

import numpy as np

from ...geometry import Fov
from ...gpu.textures import release_all
from ...headsets import COLOURS, Lens, MeshLens
from . import ResampledLens, lenses

_MESH = 14  # texture unit


@lenses.register
class Mesh(ResampledLens):
    """Sample once per channel where the mesh of that channel says."""

    name = "mesh"
    summary = "directions at the points of a grid over the panel, bilinear between them, one grid per colour"
    library = "lens/mesh.glsl"
    source = "OpenVR, IVRSystem::ComputeDistortion on a grid; meshes: the headset's file"

    def prepare(self) -> None:
        super().prepare()
        self._textures = []
        for lens in self.eye_lenses:
            assert isinstance(lens, MeshLens)
            grid = np.concatenate([lens.points[colour] for colour in COLOURS])
            size = grid.shape[1], grid.shape[0]
            self._textures.append(self.gpu.gl.texture(size, 2, grid.astype(np.float32).tobytes(), dtype="f4"))

    def close(self) -> None:
        release_all(*self._textures)

    def library_defines(self) -> dict[str, object]:
        return {**super().library_defines(), "LENS_TANGENTS": 1}

    def library_uniforms(self, fov: Fov, eye: int) -> dict[str, object]:
        self._textures[eye].use(_MESH)
        return super().library_uniforms(fov, eye)

    def of_lens(self, lens: Lens) -> dict[str, object]:
        assert isinstance(lens, MeshLens)
        return {"lens_panel": lens.panel_m, "lens_mesh": _MESH}

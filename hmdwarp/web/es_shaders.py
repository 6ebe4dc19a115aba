"""The warps' shaders as WebGL 2 takes them: the same text, as fragment shaders of GLSL ES 3.00."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from ..gpu.shaders import VERSION, flatten

PAGE = Path(__file__).parent / "page"
_IMAGE = re.compile(r"layout\(r32f\) readonly uniform image2D")
# Of `iterative` without seeds, which WebGL 2 cannot scatter: more plain steps take their place.
STEPS = 5
WARPS: Mapping[str, tuple[str, dict[str, object]]] = {
    "rotation": ("warps/rotation.comp", {"CLAMP": 0}),
    "iterative": ("warps/iterative.comp", {"PLAIN": STEPS - 1, "SLANTED": 1}),
}


def shaders() -> dict[str, str]:
    """Return each shader's text by its file's name, or its warp's."""
    own = {path.name: _as_es(str(path), {}) for path in PAGE.iterdir() if path.suffix in (".vert", ".frag")}
    written = {"WRITES_DEPTH": 1, "OUTPUT": str(PAGE / "to_web.glsl")}
    return own | {name: _as_es(path, defines | written) for name, (path, defines) in WARPS.items()}


def _as_es(path: str, defines: Mapping[str, object]) -> str:
    preface = (PAGE / "preface.glsl").read_text(encoding="utf-8")
    return _IMAGE.sub("uniform sampler2D", flatten(path, defines).text.replace(VERSION + "\n", preface))

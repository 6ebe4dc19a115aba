"""The client: makes the picture that the eye should see now from the newest rendered frame.

Warps, fills, effects and lenses are registries in packages of their own. Imports are lazy:
`from hmdwarp.client import parse_warp` loads no GPU code beyond its own.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .carry import Carry, ShownDepth, images_read, pictures_read
    from .compensator import Compensator, EyeResult, Stages
    from .geometry import ClientGeometry, ClientModel
    from .history import History
    from .inputs import PassInputs
    from .picture import ShownPicture
    from .plan import (
        CLIENT_DEPTH,
        CLIENT_MODEL,
        PANEL,
        PICTURE,
        SHOWN,
        SHOWN_DEPTH,
        Plan,
        PlannedEffect,
        Step,
        build_plan,
        needs_of,
    )
    from .settings import NoSettings
    from .variants import Choice, every_fill, every_warp, fill_text, parse_fills, parse_warp

_HOME = {
    "CLIENT_DEPTH": "plan",
    "CLIENT_MODEL": "plan",
    "Carry": "carry",
    "Choice": "variants",
    "ClientGeometry": "geometry",
    "ClientModel": "geometry",
    "Compensator": "compensator",
    "EyeResult": "compensator",
    "History": "history",
    "NoSettings": "settings",
    "PANEL": "plan",
    "PICTURE": "plan",
    "PassInputs": "inputs",
    "Plan": "plan",
    "PlannedEffect": "plan",
    "SHOWN": "plan",
    "SHOWN_DEPTH": "plan",
    "ShownDepth": "carry",
    "ShownPicture": "picture",
    "Stages": "compensator",
    "Step": "plan",
    "build_plan": "plan",
    "every_fill": "variants",
    "every_warp": "variants",
    "fill_text": "variants",
    "images_read": "carry",
    "needs_of": "plan",
    "parse_fills": "variants",
    "parse_warp": "variants",
    "pictures_read": "carry",
}

__all__ = [
    "CLIENT_DEPTH",
    "CLIENT_MODEL",
    "PANEL",
    "PICTURE",
    "SHOWN",
    "SHOWN_DEPTH",
    "Carry",
    "Choice",
    "ClientGeometry",
    "ClientModel",
    "Compensator",
    "EyeResult",
    "History",
    "NoSettings",
    "PassInputs",
    "Plan",
    "PlannedEffect",
    "ShownDepth",
    "ShownPicture",
    "Stages",
    "Step",
    "build_plan",
    "every_fill",
    "every_warp",
    "fill_text",
    "images_read",
    "needs_of",
    "parse_fills",
    "parse_warp",
    "pictures_read",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'hmdwarp.client' has no attribute '{name}'")
    value = getattr(importlib.import_module(f".{_HOME[name]}", __name__), name)
    globals()[name] = value
    return value

"""Options of a server for others."""

from __future__ import annotations

from pathlib import Path

import attrs

from ..options import Declared, group, option, same_as
from ..pipeline.options import PipelineOptions
from ..scenes.options import SceneOptions

_PIPELINE = attrs.fields(PipelineOptions)


@attrs.frozen(kw_only=True)
class ServeOptions(Declared):
    """A server for others. Errors: InputError for a value out of range."""

    scene: str = same_as(_PIPELINE.scene)
    scene_options: SceneOptions = group(SceneOptions)
    mirrors: str = same_as(_PIPELINE.mirrors)
    listen: str = option(
        "127.0.0.1:5570",
        "HOST:PORT to listen at, * for a free port, or ipc://PATH for clients on this machine, which get frames by "
        "shared memory; beyond this machine it wants a key pair or a token.",
    )
    key_pair: Path | None = option(
        None,
        "Encrypt, with the keys in NAME.key_secret and NAME.key, which are made where they are not there; clients "
        "need NAME.key.",
        kind=Path,
        metavar="NAME",
    )
    token_file: Path | None = option(None, "File with the secret that clients must share.", kind=Path)
    open: bool = option(False, "Let anybody in from beyond this machine, without a key or a token.")

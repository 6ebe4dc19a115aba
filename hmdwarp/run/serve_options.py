"""Options of a server for others."""

from __future__ import annotations

from pathlib import Path

import attrs

from ..options import Declared, Number, group, option, same_as
from ..pipeline.options import PipelineOptions
from ..scenes.options import SceneOptions
from ..sources.feed.sockets import MOST_OF_ADDRESS

_PIPELINE = attrs.fields(PipelineOptions)


@attrs.frozen(kw_only=True)
class ServeOptions(Declared):
    """A server for others. Errors: InputError for a value out of range."""

    scene: str = same_as(_PIPELINE.scene)
    scene_options: SceneOptions = group(SceneOptions)
    mirrors: str = same_as(_PIPELINE.mirrors)
    samples: int = same_as(_PIPELINE.samples)
    sample_depth: str = same_as(_PIPELINE.sample_depth)
    listen: str = option(
        "127.0.0.1:5570",
        "Address to listen at: HOST:PORT, * for a free port, or ipc://PATH for clients on this machine, which get "
        "frames through shared memory. Other machines need a key pair or a token.",
    )
    key_pair: Path | None = option(
        None,
        "Encrypt with the keys in NAME.key_secret and NAME.key, created if missing; clients need NAME.key.",
        kind=Path,
        metavar="NAME",
    )
    token_file: Path | None = option(None, "File with the secret that clients must share.", kind=Path)
    per_address: int = option(
        MOST_OF_ADDRESS,
        "Connections from one address, at most; one that is idle makes room for another.",
        valid=Number(least=1),
    )
    open: bool = option(False, "Accept clients on other machines without authentication.")

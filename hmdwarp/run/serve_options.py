"""Options of a server for others, and the secret that it shares with its clients."""

from __future__ import annotations

from pathlib import Path

import attrs

from ..errors import InputError
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
        "127.0.0.1:5570", "HOST:PORT to listen at, * for a free port; beyond this machine it wants a token."
    )
    token_file: Path | None = option(None, "File with the secret that clients must share.", kind=Path)
    open: bool = option(False, "Let anybody in from beyond this machine, without a token.")


def secret_in(path: Path | None) -> str:
    """Return the secret in a file, "" for none. Errors: InputError."""
    if path is None:
        return ""
    try:
        text = path.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"--token-file {path}: cannot be read ({error})") from error
    if not text:
        raise InputError(f"--token-file {path}: it is empty; expected a secret, such as 32 random letters")
    return text

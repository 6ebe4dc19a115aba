"""Options of a client of the feed, and the secret that it shares with its server."""

from __future__ import annotations

from pathlib import Path

import attrs

from ...errors import InputError
from ...options import Declared, Number, one_of, option
from ...options.named_files import SECRET, text_in
from .sockets import valid_address

FULL, HALF = RAW_FORMS = ("full", "half")
_STUDY = "a study shows scenes that it draws itself, with a latency that it sets"


@attrs.frozen(kw_only=True)
class FeedOptions(Declared):
    """Where frames come from, if not from here.

    Errors: InputError for a secret or a key without a server.
    """

    heading = "Server elsewhere"
    # "" for frames that are drawn here.
    connect: str = option(
        "",
        "Server to connect to, HOST:PORT. Latency is measured, and --latency ignored. In replay, --scene server "
        "takes whatever it draws.",
        valid=valid_address("--connect"),
        study=_STUDY,
    )
    server_key: Path | None = option(
        None, "Public key of the server at --connect, its NAME.key; encrypts both ways.", study=_STUDY
    )
    token_file: Path | None = option(None, "File with the secret that the server at --connect requires.", study=_STUDY)

    raw: str = option(
        FULL,
        "How frames of the server at --connect come without a codec: full (12 bytes a pixel, as drawn), half (6: sRGB "
        "bytes, inverse depth in 65535 steps up to the nearest surface).",
        valid=one_of(*RAW_FORMS),
        limits=", ".join(RAW_FORMS),
        study=_STUDY,
    )

    added_latency_ms: float = option(
        0.0,
        "Milliseconds of emulated latency behind the network to the server at --connect; --jitter, --delay-trace, "
        "--loss and --bandwidth are emulated there too.",
        name="added_latency",
        valid=Number(),
        study=_STUDY,
    )

    def __attrs_post_init__(self) -> None:
        if self.added_latency_ms and not self.connect:
            raise InputError(
                f"--added-latency {self.added_latency_ms:g} ms: it is for --connect; say --latency, or name the server"
            )
        for name, path in (("--server-key", self.server_key), ("--token-file", self.token_file)):
            if path is not None and not self.connect:
                raise InputError(f"{name} {path}: it is for --connect; name the server, or leave it out")
        if self.raw != FULL and not self.connect:
            raise InputError(f"--raw {self.raw}: it is for --connect; name the server, or leave it out")


def secret_in(path: Path | None) -> str:
    """Return the secret in a file, "" for none. Errors: InputError."""
    if path is None:
        return ""
    text = text_in(path, SECRET).strip()
    if not text:
        raise InputError(f"--token-file {path}: it is empty; expected a secret, such as 32 random letters")
    return text

"""Options of a client of the feed, the secret it shares with its server, a server's key pair.

Source: ZeroMQ RFC 26 (CurveZMQ), Bernstein's CurveCP and Curve25519.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import attrs

from ...base import Declared, InputError, Number, one_of, option
from ...base.named_files import SECRET, opened, text_in
from .sockets import valid_address, zmq_module

FULL, HALF = _RAW_FORMS = ("full", "half")
_option = partial(option, study="a study shows scenes that it draws itself, with a latency that it sets")


@attrs.frozen(kw_only=True)
class FeedOptions(Declared):
    """Where frames come from, if not from here. Errors: InputError for what lacks its server."""

    heading = "Server elsewhere"
    connect: str = _option(
        "",
        "Server to connect to, HOST:PORT. Latency is measured, and --latency ignored. In replay, --scene server "
        "takes whatever it draws.",
        valid=valid_address("--connect"),
    )
    server_key: Path | None = _option(None, "Public key of the server at --connect, its NAME.key; encrypts both ways.")
    token_file: Path | None = _option(None, "File with the secret that the server at --connect requires.")

    raw: str = _option(
        FULL,
        "How frames of the server at --connect come without a codec: full (12 bytes a pixel, as drawn), half (6: sRGB "
        "bytes, inverse depth in 65535 steps up to the nearest surface).",
        valid=one_of(*_RAW_FORMS),
        limits=", ".join(_RAW_FORMS),
    )

    added_latency_ms: float = _option(
        0.0,
        "Milliseconds of emulated latency behind the network to the server at --connect; --jitter, --delay-trace, "
        "--loss and --bandwidth are emulated there too.",
        name="added_latency",
        valid=Number(),
    )

    def __attrs_post_init__(self) -> None:
        if self.added_latency_ms and not self.connect:
            hint = "it is for --connect; say --latency, or name the server"
            raise InputError(f"--added-latency {self.added_latency_ms:g} ms: {hint}")
        for name, value in (
            ("--server-key", self.server_key),
            ("--token-file", self.token_file),
            ("--raw", None if self.raw == FULL else self.raw),
        ):
            if value is not None and not self.connect:
                raise InputError(f"{name} {value}: it is for --connect; name the server, or leave it out")


def secret_in(path: Path | None) -> str:
    if path is None:
        return ""
    text = text_in(path, SECRET).strip()
    if not text:
        raise InputError(f"--token-file {path}: it is empty; expected a secret, such as 32 random letters")
    return text


_LETTERS = 40  # of a key: 32 bytes in Z85


@attrs.frozen
class KeyPair:
    public: bytes
    secret: bytes = attrs.field(repr=False)


def key_pair(name: Path) -> tuple[KeyPair, bool]:
    """Return NAME.key and NAME.key_secret, and whether they were made. Errors: InputError."""
    zmq_module()
    public, secret = (name.with_name(name.name + ending) for ending in (".key", ".key_secret"))
    if is_new := not (public.exists() or secret.exists()):
        from zmq.auth import create_certificates

        try:
            # In a private folder, as the library makes files that all users can read.
            with TemporaryDirectory(dir=public.parent) as made:
                for source, target in zip(create_certificates(made, "new"), (public, secret), strict=True):
                    Path(source).chmod(0o600 if target == secret else 0o644)
                    Path(source).replace(target)
        except OSError as error:
            raise InputError(f"--key-pair {name}: cannot be made ({error})") from error
    found = _keys_in(secret, f"--key-pair {name}")
    if not found[1]:
        raise InputError(f"--key-pair {name}: {secret} has no secret key; take both away, and a new pair is made")
    return KeyPair(*found), is_new


def public_key(path: Path | None) -> bytes:
    return b"" if path is None else _keys_in(path, f"--server-key {path}")[0]


def _keys_in(path: Path, option: str) -> tuple[bytes, bytes]:
    zmq_module()
    from zmq.auth import load_certificate
    from zmq.utils.z85 import Z85CHARS

    try:
        with opened(path, SECRET) as file:
            public, secret = load_certificate(f"/proc/self/fd/{file.fileno()}")
    except (InputError, OSError, ValueError, IndexError) as error:
        why = error if isinstance(error, InputError) else f"{path} has no public key"
        raise InputError(f"{option}: {why}; expected a file that 'hmdwarp serve --key-pair' made") from error
    if any(len(key) != _LETTERS or not set(key) <= set(Z85CHARS) for key in (public, secret or public)):
        raise InputError(f"{option}: {path} has no Z85 key of {_LETTERS} letters; 'hmdwarp serve --key-pair' makes one")
    return public, secret or b""

"""The key pair of a server: CURVE encrypts both ways, and only who has its public key gets in.

Source: ZeroMQ RFC 26 (CurveZMQ), Bernstein's CurveCP and Curve25519.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import attrs

from ...errors import InputError
from ...options.named_files import SECRET, opened
from .sockets import zmq_module

_PUBLIC, _SECRET = ".key", ".key_secret"
_LETTERS = 40  # 32 bytes in Z85


@attrs.frozen
class KeyPair:
    """Both keys, as the library writes them."""

    public: bytes
    secret: bytes = attrs.field(repr=False)


def key_pair(name: Path) -> tuple[KeyPair, bool]:
    """Return the pair of NAME.key and NAME.key_secret, and whether it was made now.

    It is made where neither is there; only this user may read the secret one.
    Errors: InputError for files that hold no pair; MachineError without the library.
    """
    zmq_module()
    public, secret = (name.with_name(name.name + ending) for ending in (_PUBLIC, _SECRET))
    is_new = not (public.exists() or secret.exists())
    if is_new:
        _make(public, secret)
    found = _read(secret, f"--key-pair {name}")
    if not found[1]:
        raise InputError(f"--key-pair {name}: {secret} has no secret key; take both away, and a new pair is made")
    return KeyPair(found[0], found[1]), is_new


def public_key(path: Path | None) -> bytes:
    """Return the server's public key in its file, b"" for none. Errors: InputError."""
    return b"" if path is None else _read(path, f"--server-key {path}")[0]


def _make(public: Path, secret: Path) -> None:
    from zmq.auth import create_certificates

    try:
        # In a private folder, as the library makes files that all users can read.
        with TemporaryDirectory(dir=public.parent) as made:
            for source, target in zip(create_certificates(made, "new"), (public, secret), strict=True):
                Path(source).chmod(0o600 if target == secret else 0o644)
                Path(source).replace(target)
    except OSError as error:
        raise InputError(f"--key-pair {public.with_suffix('')}: cannot be made ({error})") from error


def _read(path: Path, option: str) -> tuple[bytes, bytes]:
    """Return both keys of a file, b"" for a secret one that it has not."""
    zmq_module()
    from zmq.auth import load_certificate

    try:
        with opened(path, SECRET) as file:
            public, secret = load_certificate(f"/proc/self/fd/{file.fileno()}")
    except (InputError, OSError, ValueError, IndexError) as error:
        why = error if isinstance(error, InputError) else f"{path} has no public key"
        raise InputError(f"{option}: {why}; expected a file that 'hmdwarp serve --key-pair' made") from error
    if len(public) != _LETTERS or (secret and len(secret) != _LETTERS):
        raise InputError(f"{option}: {path} has no key of {_LETTERS} letters; 'hmdwarp serve --key-pair' makes one")
    return public, secret or b""

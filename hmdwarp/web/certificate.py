"""The certificate of the page: one of the user's, or one that openssl makes and nobody has signed.

WebXR is there only for pages that come by https or from the same machine.
"""

from __future__ import annotations

import hashlib
import ipaddress
import shutil
import socket
import ssl
import subprocess
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from ..base import InputError
from ..base.named_files import SECRET, text_in

_DAYS = 825  # the most that Apple's browsers take
# Nothing of it is the system's: by the settings there it may be an authority's, which signs others.
_SETTINGS = """[req]
distinguished_name = name
x509_extensions = more
prompt = no
[name]
CN = hmdwarp
[more]
basicConstraints = critical,CA:FALSE
keyUsage = critical,digitalSignature
extendedKeyUsage = serverAuth
subjectKeyIdentifier = hash
subjectAltName = """
_MAKE = ("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", str(_DAYS))
# By the address that stands for all: one far away, to which nothing is sent; the machine's own.
_ALL_AT = {
    "0.0.0.0": ("192.0.2.1", "127.0.0.1", socket.AF_INET),
    "::": ("2001:db8::1", "::1", socket.AF_INET6),
}


def hosts_at(host: str) -> list[str]:
    """Return the addresses and names by which a browser reaches what listens at a host.

    The first is the one that leads furthest: of the way to other networks, for what listens at all.
    """
    host, name = host.strip("[]"), socket.gethostname()
    if host not in _ALL_AT:
        return list(dict.fromkeys([*_numbers_of(host), host]))
    (place, own, family), found = _ALL_AT[host], []
    with suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as out:
        out.connect((place, 9))
        found.append(out.getsockname()[0])
    found += [each for each in (*_numbers_of(name), own) if (":" in each) == (":" in host)]
    return list(dict.fromkeys([*found, "localhost", name, f"{name}.local"]))


def _numbers_of(name: str) -> list[str]:
    with suppress(OSError):
        return [str(each[4][0]).partition("%")[0] for each in socket.getaddrinfo(name, None)]
    return []


def certified(path: Path, host: str) -> tuple[ssl.SSLContext, str, bool]:
    """Return how to serve, the SHA-256 fingerprint that browsers show, and whether it was made now.

    Errors: InputError for a file without a key and its certificate, and where none can be made.
    """
    if is_new := not path.exists():
        _make(path, hosts_at(host))
    pem, found = text_in(path, SECRET), ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        found.load_cert_chain(path)
        begin, ends = (f"-----{word} CERTIFICATE-----" for word in ("BEGIN", "END"))
        first = ssl.PEM_cert_to_DER_cert(begin + pem.split(begin)[1].split(ends)[0] + ends)
    except (OSError, IndexError, ValueError) as error:
        raise InputError(
            f"--certificate {path}: expected a PEM file with a private key and its certificate ({error}); one that is "
            "not there is made"
        ) from error
    return found, hashlib.sha256(first).digest().hex(":").upper(), is_new


def _make(path: Path, hosts: list[str]) -> None:
    """Make a key and its certificate for these hosts, in one file that only this user may read."""
    if shutil.which("openssl") is None:
        raise InputError(
            f"--certificate {path}: no such file, and none can be made without the program openssl: install it, or "
            "name a PEM file with a private key and its certificate"
        )
    try:
        with TemporaryDirectory(dir=path.parent) as made:  # that only this user may enter
            settings, key, certificate = (Path(made, name) for name in ("settings", "key", "certificate"))
            names = ",".join(f"{'IP' if is_number(host) else 'DNS'}:{host}" for host in hosts)
            settings.write_text(f"{_SETTINGS}{names}\n", encoding="ascii")
            files = ("-config", settings, "-keyout", key, "-out", certificate)
            done = subprocess.run(["openssl", *_MAKE, *files], capture_output=True, text=True, check=False)
            if done.returncode:
                raise InputError(f"--certificate {path}: openssl made none ({' '.join(done.stderr.split())[-200:]})")
            key.write_bytes(key.read_bytes() + certificate.read_bytes())
            key.chmod(0o600)
            key.replace(path)
    except (OSError, UnicodeError) as error:
        raise InputError(f"--certificate {path}: cannot be made ({error})") from error


def is_number(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True

"""Client classes: what the machine at the head can do, one .toml file each."""

from __future__ import annotations

import math
from pathlib import Path

import attrs

from ...base import Table, parsed, text_of, unknown_name

# What the client has of the scene, from nothing to all. reduced: every triangle for depth, and a
# reduced model for colour. whole: the whole scene for colour too.
SCENES = ("none", "reduced", "whole")


@attrs.frozen
class Client:
    """One class of clients."""

    name: str
    summary: str
    source: str
    scene: str  # One of SCENES.
    compute_shaders: bool  # Whether it has compute shaders; without them each pixel can only look things up.
    # Whether frames may carry more than colour and inverse depth: peeled layers, a cube, ..
    more_layers: bool
    budget_ms: float = math.inf  # For one eye; infinite where the class sets no limit.
    decoder_mpx_s: float = math.inf  # Million pixels of video a second, of both eyes and all layers.
    download_mbit_s: float = math.inf  # From the server, Mbit/s.
    # As its makers state them; infinite where none is known, and times are those of this machine.
    memory_gb_s: float = math.inf
    compute_tflops: float = math.inf

    def has(self, scene: str) -> bool:
        """Return whether it has as much of the scene, one of SCENES."""
        return SCENES.index(self.scene) >= SCENES.index(scene)


_FOLDER = Path(__file__).parent
_MOST = 1e9


def client_names() -> list[str]:
    """Return the names of the shipped client classes, sorted."""
    return sorted(path.stem for path in _FOLDER.glob("*.toml"))


def load_client(name: str) -> Client:
    """Load a shipped client class by name, or the user's own .toml file by path.

    Errors: InputError naming the file and its fault.
    """
    path = Path(name) if name.endswith(".toml") else _FOLDER / f"{name}.toml"
    if not name.endswith(".toml") and not path.is_file():
        raise unknown_name("client", name, client_names())
    example = "hmdwarp/client/classes/class-2.toml"
    return parsed(
        text_of(path, "a client class, as a .toml file"), path, lambda data: _client(path.stem, data), example
    )


def _client(name: str, data: Table) -> Client:
    limits = ("budget_ms", "decoder_mpx_s", "download_mbit_s", "memory_gb_s", "compute_tflops")
    return Client(
        name=data.line("name", name),
        summary=data.line("summary"),
        source=data.line("source", ""),
        scene=data.word("scene", SCENES),
        compute_shaders=data.flag("compute_shaders"),
        more_layers=data.flag("more_layers", True),
        **{key: data.within(key, 0.0, _MOST, math.inf, above=True) for key in limits},
    )


# What a client needs that gets pictures with depth, and has nothing of the scene.
PICTURE_CLIENT = "picture"

__all__ = ["PICTURE_CLIENT", "SCENES", "Client", "client_names", "load_client"]

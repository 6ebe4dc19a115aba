"""Client classes: what the machine at the head can do, one .toml file each."""

from ._load import client_names, load_client
from ._model import SCENES, Client

# What a client needs that gets pictures with depth, and has nothing of the scene.
PICTURE_CLIENT = "picture"

__all__ = ["PICTURE_CLIENT", "SCENES", "Client", "client_names", "load_client"]

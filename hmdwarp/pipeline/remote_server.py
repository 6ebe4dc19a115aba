"""A renderer elsewhere in the place of this side's: it draws the truth, as it draws the frames."""

from __future__ import annotations

import numpy as np

from ..errors import HmdwarpError, counted
from ..frames import EyeImage
from ..geometry import View
from ..gpu.context import Gpu
from ..gpu.textures import upload
from ..scenes import Scene
from ..sources.feed.key_pairs import public_key
from ..sources.feed.message import FrameMessage
from ..sources.feed.options import FeedOptions, secret_in
from ..sources.feed.viewer import Viewer
from ..sources.server import Server, Target
from .views_apart import ViewsApart

# The scene's name where the server's own is shown, whatever it is.
SERVER_SCENE = "server"


class NoTruth(HmdwarpError):
    """The server elsewhere has not drawn what an eye should see."""


def scene_elsewhere(address: str) -> Scene:
    """Return a scene without anything in it: what there is, the server knows."""
    everywhere = np.array([[-np.inf] * 3, [np.inf] * 3])
    return Scene(SERVER_SCENE, f"drawn by {address}", (), walk_bounds_m=everywhere)


def upload_eye(target: Target, frame: FrameMessage, eye: int) -> None:
    """Put one eye's pictures of a frame into textures."""
    upload(target.colour, frame.light(eye))
    inverse_depth = frame.inverse_depths[eye]
    assert not isinstance(inverse_depth, bytes), "it is decoded before"
    upload(target.inverse_depth, inverse_depth)


class RemoteServer(Server):
    """A Server whose pictures are drawn elsewhere, each when it is asked for.

    It is a client beside the one that the frames are for, so that neither passes the other over.
    Errors: as Viewer.
    """

    def __init__(self, gpu: Gpu, feed: FeedOptions) -> None:
        super().__init__(gpu, scene_elsewhere(feed.connect))
        self._viewer = Viewer(feed.connect, secret_in(feed.token_file), public_key(feed.server_key))
        self._apart = ViewsApart()

    def draw(self, view: View, size: tuple[int, int], into: Target | None = None, time_ns: int = 0) -> EyeImage:
        """Return what the server draws for the view. Errors: NoTruth where it draws nothing."""
        found = self._viewer.fetch(view, size, time_ns)
        if found is None:
            raise NoTruth("the server has not drawn the truth")
        self._apart.take(view, found.views[0])
        target = into if into is not None else self.acquire(size)
        upload_eye(target, found, 0)
        return EyeImage(view, target.colour, target.inverse_depth, drawn_ns=time_ns)

    def about(self, untold: int) -> str:
        """Return what the truth is, in a sentence or two; untold: pictures that lack it."""
        told = "The truth is what the server drew for the shown views."
        if self._apart:
            told += f" Its views were {self._apart}: the figures count that as error."
        if untold:
            told += f" It drew none for {counted(untold, 'picture')}, which were not measured."
        return told

    def close(self) -> None:
        """Free what was uploaded, and hang up."""
        self._viewer.close()
        super().close()

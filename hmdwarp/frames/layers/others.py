"""Other pictures of the same scene: the other eye's, and older ones that the client keeps."""

from __future__ import annotations

from typing import TypeVar

import attrs

from . import EyeSizes, Layer, layers

Picture = TypeVar("Picture")


@attrs.frozen
class Others:
    """Which other pictures a plan uses."""

    # How many older frames the client keeps.
    past: int = 0
    # The least time between two of them.
    spacing_ns: int = 0
    # Whether the other eye's picture is used as well.
    other_eye: bool = False
    # How many frames straight before the newest the client keeps beside those.
    recent: int = 0

    def __bool__(self) -> bool:
        """Return whether any other picture is used."""
        return bool(self.past or self.other_eye or self.recent)

    def of(self, carried: Others, pictures: tuple[Picture, ...]) -> tuple[Picture, ...]:
        """Return those that this needs of the pictures that `carried` brought."""
        skipped = int(carried.other_eye and not self.other_eye)
        return pictures[skipped : skipped + self.count]

    @property
    def count(self) -> int:
        """The most other pictures that one eye gets, without the recent ones."""
        return self.past + self.other_eye


@layers.register
class OtherPictures(Layer):
    """Adds nothing to a frame: these pictures are frames that the link has brought already.

    The amount is an Others.
    """

    name = "others"
    summary = "the other eye's picture and older frames, which the client has already"
    of_client = True
    nothing, something = Others(), Others(past=1, other_eye=True)

    @classmethod
    def bytes(cls, amount: Others, sizes: EyeSizes) -> int:
        return 0

    @classmethod
    def merged(cls, amount: Others, other: Others) -> Others:
        """Return enough for both, with the shorter of their spacings."""
        spacings = [each.spacing_ns for each in (amount, other) if each.past]
        past, other_eye = max(amount.past, other.past), amount.other_eye or other.other_eye
        return Others(past, min(spacings, default=0), other_eye, max(amount.recent, other.recent))

    @classmethod
    def serves(cls, carried: Others, needed: Others) -> bool:
        """Return whether at least as many are kept, equally far apart; more do not disturb."""
        past = not needed.past or (needed.past <= carried.past and needed.spacing_ns == carried.spacing_ns)
        return past and carried.other_eye >= needed.other_eye and carried.recent >= needed.recent

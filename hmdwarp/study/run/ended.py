"""How a session leaves its steps before they are all done."""

from __future__ import annotations


class Over(Exception):  # noqa: N818 (nothing went wrong)
    """It ends here, for good. args: the status it ends with, as the store has it."""

    @property
    def status(self) -> str:
        return self.args[0]


class Broken(Exception):  # noqa: N818 (nothing went wrong)
    """It ends for now, and may be gone on with. args: why, in words."""

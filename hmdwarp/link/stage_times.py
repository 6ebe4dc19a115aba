"""The times that rendering, encoding and decoding add to a frame's way, given or measured."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import attrs

from ..errors import InputError

MEASURED = "measured"
_MOST_MS = 60_000.0
_WANTED = "expected fixed, sum, or sum:render=8,encode=5,decode=4 with milliseconds, or measured, for each"


@attrs.frozen
class StageTimes:
    """The time of each stage for a frame of the full resolution, in ms; None for what it took here.

    Errors: InputError for a number out of range.
    """

    render: float | None = None
    encode: float | None = None
    decode: float | None = None

    def __attrs_post_init__(self) -> None:
        for name, given in attrs.asdict(self).items():
            if given is not None and not 0 <= given <= _MOST_MS:
                raise InputError(f"response {name}={given:g}: expected 0 to {_MOST_MS:g} ms")

    @property
    def given_ns(self) -> int:
        """The sum of those that are given."""
        return sum(round(given * 1e6) for given in attrs.astuple(self) if given is not None)

    def taken_ns(self, measured_ms: Mapping[str, float], share: float) -> Iterator[int]:
        """Yield what each stage takes, in their order.

        measured_ms: by name; 0 where nothing was measured. share: of the pixels of the full
        resolution; given times are in proportion.
        """
        for name, given in attrs.asdict(self).items():
            yield round((measured_ms.get(name, 0.0) if given is None else given * share) * 1e6)


def parse_response(text: str) -> StageTimes | None:
    """Parse 'sum', 'sum:render=8,encode=5,decode=measured'; 'fixed' or '' is None.

    With one time given, stages that are not named take none. Errors: InputError.
    """
    name, colon, rest = (bit.strip() for bit in text.partition(":"))
    if name in ("", "fixed") and not colon:
        return None
    if name != "sum":
        raise InputError(f"--response '{text}': {_WANTED}")
    if not colon:
        return StageTimes()
    times: dict[str, float | None] = dict.fromkeys(attrs.fields_dict(StageTimes), 0.0)
    said = set[str]()
    for part in rest.split(","):
        stage, _, value = (bit.strip() for bit in part.partition("="))
        if stage not in times or stage in said:
            raise InputError(f"--response '{text}': {_WANTED}")
        said.add(stage)
        try:
            times[stage] = None if value == MEASURED else float(value)
        except ValueError:
            raise InputError(f"--response '{text}': {_WANTED}") from None
    return StageTimes(**times)

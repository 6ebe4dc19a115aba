"""Options of `hmdwarp bench`, `bench merge` and `compare`, checked before anything is started."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from ...base import (
    DEFAULT_GUARD,
    Declared,
    Guard,
    InputError,
    Number,
    PaperOptions,
    force_field,
    group,
    guard_field,
    names_in,
    one_of,
    option,
    out_field,
    path_of,
    same_as,
    several,
    split_names,
)
from ...client.classes import PICTURE_CLIENT
from ...link import LinkOptions
from ...link.codec import Coding
from ...poses.options import DEFAULT_PREDICTOR, PREDICTORS
from ...run import RunOptions
from ...scenes import EXTRAPOLATED
from ..sweep.options import RecordedOptions, own_first
from .suites import suites, with_suite

Size = tuple[int, int]

_RUN, _LINK = attrs.fields(RunOptions), attrs.fields(LinkOptions)
# The last two are complete: they leave nothing empty. cases.py says with which warps they run.
FILLS = ("none", "interpolate", "pyramid", "memory+pyramid")


def _size(value: Any) -> Size:
    sides = tuple(value)
    if len(sides) != 2 or not all(isinstance(side, int) and side >= 1 for side in sides):
        raise InputError(f"--size {value!r}: expected (width, height) in pixels of one eye")
    return sides


DEFAULT_SIZES = ((1280, 800),)


def _suite(what: str) -> Any:
    """Return the option that names a suite. what: it is, with {} for their names."""
    names = " or ".join(suites())
    return option("", f"Named {what.format(names)}", valid=one_of("", *suites()), limits=names)


@attrs.frozen(kw_only=True, field_transformer=own_first)
class BenchOptions(RecordedOptions):
    """Options of a bench: all combinations of warps, fills, latencies, scenes and so on.

    Errors: InputError for a number that makes no sense, and for an empty list.
    """

    # What a recording has itself, or cannot have.
    with_frames = ("recordings", "scenes", "predict", "rate_hz", "strategies")
    why_not = "a bench takes what was recorded"

    # Sets what is run; "" for none.
    suite: str = _suite("benchmark: {}. It has a version, says what is run, and takes means over all heads and scenes.")
    also: tuple[Path, ...] = option(
        (),
        "Scene file, or folder of recorded frames, that a suite takes besides its own. For several, repeat it.",
        kind=list,
        default=None,
        metavar="PATH",
        parse=lambda texts: tuple(path_of(text, "--also") for text in texts),
    )
    scenes: tuple[str, ...] = several(_RUN.scene, (_RUN.scene.default,))
    latencies_ms: tuple[float, ...] = several(_RUN.latency_ms, (_RUN.latency_ms.default,))
    # Names, with settings where they matter (`mesh:cut=slope`); empty for all that warp a late
    # picture, their variants and the baselines.
    warps: tuple[str, ...] = several(
        _RUN.warp,
        (),
        f"Warp: {names_in('client/warps')}, or cv2.warpFrame; by default all that warp a late picture, and the methods "
        "of other systems. Settings follow a colon, as in mesh:cut=slope.",
        split=split_names,
    )
    # In addition to the warps that are named, or alone.
    strategies: tuple[str, ...] = several(
        _RUN.strategy,
        (),
        f"Strategy to compare, instead of all warps or along with those of --warp: {names_in('client/strategies')}.",
        split=split_names,
    )
    fills: tuple[str, ...] = several(
        _RUN.fill, FILLS, f"Fill: {names_in('client/fills')}, or several with +", split=split_names
    )
    effects: str = same_as(_RUN.effects)
    sizes: tuple[Size, ...] = several(_RUN.size, DEFAULT_SIZES, "Pixels of one eye", each=_size)
    fovea_deg: float | None = same_as(_RUN.fovea_deg)
    rim: int = same_as(_RUN.rim)
    lens: str = same_as(_RUN.lens, "none", help="Lens correction, timed too; figures are of the picture before it.")
    # Empty for the display's.
    server_rates_hz: tuple[float, ...] = several(_LINK.server_rate_hz, ())
    guard: Guard = guard_field(DEFAULT_GUARD)
    # Of all combinations, `none` among them, as of a replay and what it is compared with.
    predict: str = same_as(
        _RUN.predict,
        DEFAULT_PREDICTOR,
        help=f"Head pose that the server draws for, by predictor: {', '.join(PREDICTORS)}. All warps have the same "
        "late frames.",
    )
    horizon_ms: float | None = same_as(_RUN.horizon_ms)
    # Six instants spread over a recording and both eyes by turns: FLIP and SSIM of a 1280x800
    # picture take 0.6 s, and seventeen warps with two fills on two recordings make 68 pictures an
    # instant. Two rounds for both eyes at each make 24 times per combination.
    instants: int = option(6, "Refreshes measured in each case, evenly spread.", valid=Number(least=1))
    rounds: int = option(2, "Timed runs at each instant, after one to warm up.", valid=Number(least=1))
    # All combinations are measured; the front is of those that it can run.
    client: str = same_as(_RUN.client, PICTURE_CLIENT, help="Client for the Pareto front; everything is measured.")
    out: Path = out_field(Path("out/bench"), "Folder for bench.csv, bench.json and bench.html.")
    paper: PaperOptions = group(PaperOptions)

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields that were set. Errors: InputError."""
        said = with_suite(said)
        values = super().values_of(said)
        return values if said.get("frames") is None else {"guard": 1.0, **values, "predict": "none"}


@attrs.frozen(kw_only=True)
class MergeOptions(Declared):
    """Which benches to join. Errors: InputError for fewer than two folders."""

    folders: tuple[Path, ...] = option(
        attrs.NOTHING, "Folders of benches, two or more.", kind=list, positional=True, metavar="DIR",
        parse=lambda texts: tuple(path_of(text, "DIR") for text in texts),
    )  # fmt: skip
    out: Path = out_field(attrs.NOTHING, "Folder for bench.csv, bench.json and bench.html of all.")
    force: bool = force_field()
    command: str = ""

    def __attrs_post_init__(self) -> None:
        if len(self.folders) < 2:
            raise InputError(f"{len(self.folders)} folder to merge: expected two or more")


SIZE, START_S = (640, 400), 1.0


@attrs.frozen
class _Coding(Coding):
    codec: str = same_as(attrs.fields(Coding).codec, "h264")


@attrs.frozen(kw_only=True, field_transformer=own_first)
class CompareOptions(RecordedOptions):
    """Every strategy on every recording at every latency, over the same link.

    Errors: InputError for a value out of range, and for an empty list.
    """

    with_frames = ("recordings", "scene", "headset", "rate_hz")
    why_not = "all are compared on the camera's own frames, head and rate"

    # Sets what is run, in scenes and over links of which there may be several; "" for none.
    suite: str = _suite(
        "comparison: {}. It says what is run, over emulated links, and takes means over all heads and scenes."
    )
    # With settings where they matter; empty for all.
    strategies: tuple[str, ...] = several(
        _RUN.strategy, (), f"Strategy: {names_in('client/strategies')}; by default all.", split=split_names
    )
    latencies_ms: tuple[float, ...] = several(_RUN.latency_ms, (200.0, 400.0, 800.0))
    clients: tuple[str, ...] = several(
        _RUN.client,
        ("class-1", "class-2", "class-3"),
        f"Clients to draw Pareto fronts for: {names_in('client/classes', '*.toml')}, or a .toml file",
    )
    scene: str = same_as(_RUN.scene)
    repair: str = same_as(_RUN.repair)
    size: tuple[int, int] | None = same_as(
        _RUN.size, help=f"Pixels of one eye, by default {SIZE[0]}x{SIZE[1]}, or as recorded."
    )
    start_s: float = same_as(_RUN.start_s, START_S)
    seconds: float | None = same_as(_RUN.seconds, 1.0, help="Seconds to show of each recording.")
    metrics_every: int = same_as(_RUN.metrics_every)
    jod_s: float = same_as(_RUN.jod_s)
    client_motion: str = same_as(_RUN.client_motion, EXTRAPOLATED)  # no client foresees
    fovea_deg: float | None = same_as(_RUN.fovea_deg)
    rim: int = same_as(_RUN.rim)
    network: LinkOptions = group(LinkOptions)
    coding: Coding = group(_Coding)
    out: Path = out_field(Path("out/compare"), "Folder for compare.html, compare.json and compare.csv.")
    paper: PaperOptions = group(PaperOptions)

    @property
    def scenes(self) -> tuple[str, ...]:
        return tuple(suites()[self.suite].compare["scene"][0].split(",")) if self.suite else (self.scene,)

    @property
    def links(self) -> tuple[LinkOptions, ...]:
        """The links, each with the rest of the options."""
        if not self.suite:
            return (self.network,)
        lived = [LinkOptions.of(link) for link in suites()[self.suite].compare["links"]]
        return tuple(attrs.evolve(self.network, bandwidth=link.bandwidth, loss=link.loss) for link in lived)

    @property
    def eye_size(self) -> tuple[int, int] | None:
        """Pixels of one eye; None for those of recorded frames."""
        return self.size or (None if self.frames is not None else SIZE)

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields that were set. Errors: InputError."""
        said = with_suite(said, compares=True)
        values = super().values_of(said)
        # A second into a recording that may last less is not begun unless it is asked for.
        if values.get("frames") is not None and values.get("start_s", START_S) == START_S:
            values["start_s"] = 0.0
        return values

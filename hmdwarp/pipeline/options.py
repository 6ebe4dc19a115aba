"""Options of every run, checked before anything is started."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, Self

import attrs

from ..errors import InputError
from ..link import LinkOptions
from ..link.codec import Coding
from ..options import DISPLAY, PICTURE, Declared, Number, Option, group, names_in, option
from ..scenes.options import SceneKey, SceneOptions

AUTO = "auto"  # the automatic choice of warp and of guard band


def parse_size(text: str) -> tuple[int, int]:
    """Return (640, 400) for '640x400'. Errors: InputError."""
    match = re.fullmatch(r"(\d{1,6})\s*[xX]\s*(\d{1,6})", text.strip())
    if not match or 0 in map(int, match.groups()):
        raise InputError(f"--size '{text}': expected WIDTHxHEIGHT in pixels of one eye, like 640x800")
    return int(match.group(1)), int(match.group(2))


def parse_guard(text: str) -> float | Literal["auto"]:
    """Return 'auto' or a number. Errors: InputError."""
    if text.strip() == AUTO:
        return "auto"
    try:
        return float(text)
    except ValueError as error:
        raise InputError(f"--guard '{text}': expected a number of at least 1, or {AUTO}") from error


def _fill_for(warp: str, fill: str | None, *, fused: bool, wide: bool) -> str:
    """Return the chosen fill, or the default one: none for a warp fused with the lens.

    wide: run that fill first. Errors: InputError for a fill with warp auto, which chooses its own.
    """
    if warp == AUTO and (fill is not None or wide):
        asked = "--wide" if fill is None else f"--fill {fill}"
        raise InputError(f"{asked}: --warp auto chooses the fill too; leave one of the two out")
    usual = "none" if fused else "interpolate"
    chosen = usual if fill is None else fill
    if not wide:
        return chosen
    return "wide" if chosen == "none" else f"wide+{chosen}"


def _check_guard(instance: object, field: attrs.Attribute[Any], value: float | str) -> None:
    if value != AUTO:
        Number(least=1.0)(instance, field, value)


_WIDE = Option(
    "A second, wide and coarse view with every frame: fill wide before the others.", bool, False, name="wide"
)


@attrs.frozen
class PipelineOptions(Declared):
    """Options of the path from the server to the eye.

    Errors: InputError for a value out of range.
    """

    scene: str = option(
        "room", f"Scene: {names_in('scenes/library')}, or a .glb, .gltf, .obj or .ply file.", study=PICTURE
    )
    # Where the scene is a file.
    scene_options: SceneOptions = group(SceneOptions)
    # From drawing a frame to showing it.
    latency_ms: float = option(200.0, "Milliseconds from drawing a frame to showing it.", unit="ms", valid=Number())
    warp: str = option("forward", f"Warp: {names_in('client/warps')}; or auto, which chooses warp and fill.")
    # Per eye; for warp "auto" only, which takes the most accurate warp and fill within it.
    budget_ms: float | None = option(
        None, "Milliseconds for one eye that --warp auto keeps to.", kind=float, unit="ms", valid=Number(above=True)
    )
    # The bench.json that warp "auto" chooses from; None measures all warps on the run's own frames
    # first.
    bench: Path | None = option(
        None,
        "bench.json that --warp auto chooses from; by default it tries all on this run first.",
        kind=Path,
        convert=attrs.converters.optional(Path),
    )
    # Ignored by warp "auto", which chooses its own.
    fill: str = option(
        "interpolate",
        f"Fill: {names_in('client/fills')}, or several with +. [default: interpolate; auto's own]",
        default=None,
    )
    # In the syntax of client.effects.EffectRegistry.selected.
    effects: str = option(
        "auto",
        f"auto (what the scene calls for), none, or of {names_in('client/effects')}: NAME forces, no-NAME forbids.",
        study=PICTURE,
    )
    # How the server draws plane mirrors, see server.Server.
    mirrors: str = option(
        "geometry", "Draw plane mirrors by geometry, or from what is on the screen (misses stay empty).", study=PICTURE
    )
    lens: str = option(
        "radial",
        f"Lens correction: {names_in('client/lens')}; by default the headset's own.",
        default=None,
        study=PICTURE,
    )
    headset: str = option(
        "rift-dk1",
        f"Headset that is emulated: {names_in('headsets', '*.toml')}, or a .toml file.",
        study=DISPLAY,
    )
    # (w, h) of one eye.
    size: tuple[int, int] | None = option(
        None, "Pixels of one eye; by default the display's.", metavar="WxH", parse=parse_size, study=DISPLAY
    )
    # None for the display's own rate.
    rate_hz: float | None = option(
        None,
        "Refreshes per second; by default the display's.",
        kind=float,
        unit="Hz",
        valid=Number(above=True, most=1000),
        study=DISPLAY,
    )
    # "auto" is replaced by a number before a run is built, see run.guard.
    guard: float | Literal["auto"] = option(
        1.0,
        "Draw this many times the field of view (in tangents) on the server; auto: as the trace needs.",
        kind=str,
        default="1",
        numeric=True,
        parse=parse_guard,
        valid=_check_guard,
        beside=(_WIDE,),  # the other way to fill beyond the border
    )
    fused: bool = option(False, "Warp and apply the lens in one resample; for gather warps, without fill.")
    # From the display's first row to its last; 0 for a global display.
    scanout_ms: float = option(
        0.0, "Milliseconds that the display takes from its first row to its last.", unit="ms", valid=Number(most=100)
    )
    # Warps that cannot follow show all rows as in the middle of the scan-out.
    follow_scanout: bool = option(
        True,
        "Warp each row for its own instant, where the warp can, or all for the middle one.",
        off="--no-follow-scanout",
    )
    # Delay variation, loss and queueing, on top of the latency.
    network: LinkOptions = group(LinkOptions)
    # Encoding and decoding on the link.
    coding: Coding = group(Coding)
    predict: str = option(
        "none",
        f"Head pose that the server draws for, by predictor: {names_in('poses/predictors')}; cav is short for "
        "constant_velocity.",
    )
    horizon_ms: float = option(100.0, "Milliseconds to predict ahead at most.", unit="ms", valid=Number())

    def __attrs_post_init__(self) -> None:
        if self.chooses_warp:
            self._check_auto()
        elif self.budget_ms is not None:
            raise InputError(
                f"--budget {self.budget_ms:g} ms: only --warp auto keeps to a budget; '{self.warp}' takes what it takes"
            )
        elif self.bench is not None:
            raise InputError(
                f"--bench {self.bench}: only --warp auto chooses from a benchmark; '{self.warp}' is chosen already"
            )

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields whose options were set. Errors: InputError."""
        values = super().values_of(said)
        fused, wide = bool(said.get("fused")), bool(said.get("wide"))
        values["fill"] = _fill_for(said.get("warp", ""), said.get("fill"), fused=fused, wide=wide)
        if "lens" in said and said["lens"] is None:
            values["lens"] = _own_lens(values.get("headset", attrs.fields(cls).headset.default))
        return values

    @property
    def scene_key(self) -> SceneKey:
        """What load_scene takes: the scene's name or file, and how the file is read."""
        return self.scene, self.scene_options

    @property
    def chooses_warp(self) -> bool:
        """Whether the run chooses warp and fill itself, to stay within its budget."""
        return self.warp == AUTO

    @property
    def guard_factor(self) -> float:
        """The guard as a number. Errors: InputError while it is "auto"."""
        if isinstance(self.guard, str):
            raise InputError("--guard auto looks at a whole trace first: give a number, or replay a recording")
        return self.guard

    def with_pair(self, warp: str, fill: str) -> Self:
        """Return the options with this warp and fill, in place of an automatic choice."""
        return attrs.evolve(self, warp=warp, fill=fill, budget_ms=None, bench=None)

    def _check_auto(self) -> None:
        if self.budget_ms is None:
            raise InputError(
                "--warp auto chooses what fits into a budget: say how many milliseconds there are for one eye "
                "(--budget MS)"
            )
        if self.fused:
            raise InputError(
                "--fused with --warp auto: its warps must have the picture between warp and lens, to be measured; "
                "leave one out"
            )


def _own_lens(headset: str) -> str:
    from ..headsets import load_headset

    return "radial" if load_headset(headset).lens is not None else "none"

"""Options of a replay, a live run and a recording, checked before anything is started."""

from __future__ import annotations

import functools
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import attrs

from ..base import (
    AUTO,
    DISPLAY,
    PICTURE,
    Declared,
    InputError,
    Number,
    force_field,
    group,
    names_in,
    one_of,
    option,
    options_of,
    out_field,
    same_as,
    several,
)
from ..link.codec import VIDEOS, Coding
from ..pipeline.options import (
    DISPLAYED,
    SERVER_SCENE,
    PipelineOptions,
    ProxyOptions,
    refuse_without_frames,
    with_frames,
)
from ..poses.options import MOTIONS, TraceOptions
from ..scenes.options import SEED, SceneOptions, seed_of
from ..sources.feed.options import FeedOptions
from ..sources.feed.sockets import MOST_OF_ADDRESS, valid_address
from ..sources.sequences.options import SequenceOptions

SOURCES = (AUTO_SOURCE, OPENXR, DESKTOP, OFFSCREEN) = ("auto", "openxr", "desktop", "offscreen")
SYNTHETIC = "synthetic"
VIEWS = (BOTH, FLAT) = ("both", "flat")
MOST_COMPARED = 2  # what a chart shows besides the run
_BETWEEN = re.compile(r",(?!\s*\w+=)")  # commas but those within a warp's settings
_SECONDS = "how long a condition is shown stands in [trial] and [practice]"
_SAID_TO_RUN = "is said to 'hmdwarp study run'"

_measuring = functools.partial(option, heading="Measuring")
_of_display = functools.partial(option, study=DISPLAY, heading=DISPLAYED)


@attrs.frozen(kw_only=True)
class RunOptions(PipelineOptions):
    """A replay: its trace, what to measure and what to keep.

    Errors: InputError for a value out of range.
    """

    draws_truth: ClassVar[bool] = True

    trace: str = option(
        "",
        "A head trace file, or the name of a shipped recording, like look-around; with --frames by default the "
        "recording's own head.",
        positional=True,
        names_files=True,
        default=None,
    )
    start_s: float = option(0.0, "Seconds into the trace at which to start.", valid=Number())
    seconds: float | None = option(None, "Seconds to show; by default all.", unit="s", valid=Number(above=True))
    input: str = option(
        "",
        "What people do in a scene that reacts, like playroom: seed:N for pushes and switches by chance, or a CSV "
        "file as live --record writes it beside the trace.",
        metavar="FILE",
        names_files=True,
        default=None,
        study=f"what people do {_SAID_TO_RUN}",
        valid=lambda _, __, value: seed_of(value) if value.startswith(SEED) else None,
    )
    # Keep the head where the trace has it, on the trace's own clock, so that moving objects of the
    # scene are where they were then. Otherwise time begins at 0, and a trace that leaves the scene
    # is moved into it.
    as_recorded: bool = False
    against: str = option(
        "none",
        "Warps to compare with, each alone or with its fills: none,forward+interpolate. none: the late picture as it "
        "is; '' for no comparison.",
        may_be_empty=True,
    )
    metrics_every: int = _measuring(
        10, "Measure one in n refreshes, unevenly spread, so that nothing periodic is missed.", valid=Number(least=1)
    )
    # 0 for not at all.
    jod_s: float = _measuring(
        0.0,
        "Also rate every picture by ColorVideoVDP, in clips of this many seconds (pip install '.[jod]'); slow.",
        valid=Number(most=60),
    )
    workers: int | None = _measuring(
        None, "Measuring threads; 0 measures in the loop; by default one per core, at most 8.", valid=Number(most=256)
    )
    images: int = option(6, "Keep about this many refreshes as pictures.", valid=Number())
    video: bool = option(False, "Also write replay.mp4: both panels, as the display gets them.")
    trace_options: TraceOptions = group(TraceOptions)
    feed: FeedOptions = group(FeedOptions)
    out: Path = out_field(Path("out/replay"), "Folder for summary.json, frames.csv, images/ and report.html.")
    force: bool = force_field()
    command: str = ""

    def __attrs_post_init__(self) -> None:
        super().__attrs_post_init__()
        if not self.trace and not self.source_kind.has_head:
            raise InputError("no TRACE: name a head trace file or a shipped recording, like look-around")
        if len(self.compared) > MOST_COMPARED:
            raise InputError(
                f"--against {self.against}: expected at most {MOST_COMPARED} warps; 'hmdwarp bench' compares any number"
            )

    @property
    def compared(self) -> tuple[tuple[str, str], ...]:
        """Warp and fill of each comparison, without the run's own."""
        asked = [text.strip().partition("+") for text in _BETWEEN.split(self.against) if text.strip()]
        pairs = dict.fromkeys((warp, fill or "none") for warp, _, fill in asked)
        return tuple(pair for pair in pairs if pair != (self.warp, self.fill))


@attrs.frozen(kw_only=True)
class LiveOptions(PipelineOptions):
    """A live run.

    Errors: InputError for a value out of range.
    """

    not_offered: ClassVar[tuple[str, ...]] = ("scanout", "follow_scanout")
    usual_eye_distance_mm: ClassVar[float] = 63.0

    # "auto": the headset's lens where a window emulates it, none where a runtime corrects its own.
    lens: str = option(
        AUTO, f"Lens correction: {names_in('client/lens')}; auto: the headset's that a window emulates.", study=PICTURE
    )
    source: str = option(
        AUTO_SOURCE,
        "Display: openxr, desktop, offscreen (none), or auto: headset, else window.",
        valid=one_of(*SOURCES),
        study=f"where it is shown {_SAID_TO_RUN}",
    )
    trace: str = option(
        "",
        "Recorded head, by name or file, that moves the window or the offscreen display; by default yours, and the "
        "camera's own with --frames.",
        default=None,
        study=f"whose head it is, {_SAID_TO_RUN}",
    )
    view: str = option(
        BOTH, "In the window: both eyes as the panel gets them, or one flat view.", valid=one_of(*VIEWS), study=DISPLAY
    )
    full_screen: bool = _of_display(False, "Open the window over the full screen.")
    vsync: bool = _of_display(True, "Wait for the screen's refresh.", off="--no-vsync")
    panel: bool = option(
        True, "Show controls and plots (pip install '.[panel]').", off="--no-panel", study="a study shows no controls"
    )
    depth_layer: bool = _of_display(True, "Hand the warped depth to a runtime that takes it.", off="--no-depth-layer")
    seconds: float | None = option(
        None, "Stop after this long; by default never.", unit="s", valid=Number(above=True), study=_SECONDS
    )
    pictures: int | None = option(
        None, "Stop after this many pictures; by default never.", valid=Number(least=1), study=f"{_SECONDS}, in seconds"
    )
    record: Path | None = out_field(
        None,
        "Write the head's trace to this file while running.",
        study="the head's trace of every trial is recorded anyway",
    )
    out: Path | None = out_field(
        None,
        "Folder for frames.csv, summary.json and report.html; by default none.",
        study="what was shown is kept in the study's store",
    )
    force: bool = force_field("the study's store overwrites nothing")
    reconnect_s: float = _of_display(60.0, "Seconds to wait for a runtime that went away.", valid=Number())
    hang_s: float = _of_display(5.0, "Seconds of silence after which a runtime is given up.", valid=Number(least=0.1))
    feed: FeedOptions = group(FeedOptions)
    command: str = ""

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields whose options were set; the scene is the server's if none is named."""
        return ({"scene": SERVER_SCENE} if said.get("connect") else {}) | super().values_of(said)

    def __attrs_post_init__(self) -> None:
        super().__attrs_post_init__()
        if self.guard == AUTO:
            raise InputError(
                "--guard auto looks at the whole trace first, which a live run has not: give a number, or replay a "
                "recording"
            )
        has_head = self.source_kind.has_head
        if has_head and self.source == OPENXR:
            raise InputError(
                f"--source {OPENXR} with --frames: a headset has a head of its own, and what was recorded is seen from "
                f"where the camera was; take {DESKTOP} or {OFFSCREEN}"
            )
        if self.source == OFFSCREEN and not self.trace and not has_head:
            raise InputError("--source offscreen: nobody's head leads it; name a recorded one by --trace, such as walk")
        if self.trace and self.source in (AUTO_SOURCE, OPENXR) and not has_head:
            raise InputError(
                f"--trace {self.trace}: a headset has a head of its own; take --source desktop or offscreen"
            )
        if self.warp == AUTO and self.bench is None:
            raise InputError(
                "--warp auto in a live run needs a benchmark to choose from: make one by 'hmdwarp bench', give it by "
                "--bench"
            )


_LIVE = attrs.fields(LiveOptions)


@attrs.frozen(kw_only=True)
class RecordOptions(Declared):
    """A recording of a head. Errors: InputError for a value out of range."""

    out: Path = out_field(attrs.NOTHING, "The trace to write: a new file.")
    force: bool = force_field()
    source: str = option(
        OPENXR,
        "Head to record: openxr (a headset), desktop (a window) or synthetic (see --kind).",
        valid=one_of(OPENXR, DESKTOP, SYNTHETIC),
    )
    seconds: float | None = option(
        None, "Stop after this long; by default at Ctrl-C.", unit="s", valid=Number(above=True)
    )
    rate_hz: float | None = option(
        None, "Poses per second; by default the display's, 90 for synthetic motion.", valid=Number(least=1, most=1000)
    )
    kind: str = option("look-around", f"Synthetic motion: {MOTIONS}; it ends by itself.")
    # What the window shows.
    scene: str = same_as(_LIVE.scene)
    scene_options: SceneOptions = group(SceneOptions)
    reconnect_s: float = same_as(_LIVE.reconnect_s)
    hang_s: float = same_as(_LIVE.hang_s)


_PIPELINE = attrs.fields(PipelineOptions)


@attrs.frozen(kw_only=True)
class _ListenOptions(Declared):
    """Where clients are served, and who may be one."""

    listen: str = option(
        "127.0.0.1:5570",
        "Address to listen at: HOST:PORT, * for a free port. Other machines need a key pair or a token.",
        valid=valid_address("--listen", serves=True),
    )
    key_pair: Path | None = option(
        None,
        "Encrypt with the keys in NAME.key_secret and NAME.key, created if missing; clients need NAME.key.",
        metavar="NAME",
    )
    token_file: Path | None = option(None, "File with the secret that clients must share.")
    per_address: int = option(
        MOST_OF_ADDRESS,
        "Connections from one address, at most; one that is idle makes room for another.",
        valid=Number(least=1),
    )
    open: bool = option(False, "Accept clients on other machines without authentication.")


@attrs.frozen(kw_only=True)
class ProxyRunOptions(_ListenOptions):
    """A proxy between a server and its clients. Errors: InputError for a value out of range."""

    connect: str = same_as(attrs.fields(FeedOptions).connect)
    server_key: Path | None = same_as(attrs.fields(FeedOptions).server_key)
    warp: str = option(
        "multi:views=1,frames=1,eye=own",
        f"Warp on the proxy: {names_in('client/warps')}; by default between two reference views, as Yoo (2010) does.",
    )
    fill: str = option("memory+pyramid", f"Fill on the proxy: {names_in('client/fills')}, or several with +.")
    guard: float = same_as(attrs.fields(ProxyOptions).guard)
    codec: str = option("h264", f"Codec between server and proxy, at its own quality: {names_in('link/codec/codecs')}.")

    def __attrs_post_init__(self) -> None:
        if not self.connect:
            raise InputError("no server: name the one to warp for by --connect HOST:PORT")

    @property
    def coding(self) -> Coding:
        """How frames are coded on their way to the proxy."""
        return Coding(self.codec)

    @property
    def feed(self) -> FeedOptions:
        """The server, as a client of it has it."""
        return FeedOptions(connect=self.connect, server_key=self.server_key)


@attrs.frozen(kw_only=True)
class ServeOptions(_ListenOptions):
    """A server for others. Errors: InputError for a value out of range."""

    scene: str = same_as(_PIPELINE.scene)
    scene_options: SceneOptions = group(SceneOptions)
    frames: Path | None = same_as(_PIPELINE.frames)
    sequence_options: SequenceOptions = group(SequenceOptions)
    repair: str = same_as(_PIPELINE.repair)
    mirrors: str = same_as(_PIPELINE.mirrors)
    samples: int = same_as(_PIPELINE.samples)
    web: str = option(
        "",
        "Address of the page for browsers, HOST:PORT, * for a free port; prints what to open. A headset's browser "
        "needs --certificate, or a cable that forwards the port.",
    )
    certificate: Path | None = option(
        None, "PEM file with the private key and certificate of --web, for https; made by openssl if missing."
    )
    codec: str = option(
        AUTO,
        f"With --web: video of the colours, {', '.join(VIDEOS)}; by default the best that a browser decodes in "
        "hardware, else h264.",
        valid=one_of(AUTO, *VIDEOS),
    )
    out: Path | None = out_field(
        None, "With --web: folder for session.jsonl, a line a second of each browser's session; by default none."
    )

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields whose options were set. Errors: InputError."""
        return super().values_of(with_frames(said, {option.name: option.default for option in options_of(cls)}))

    def __attrs_post_init__(self) -> None:
        for name, usual in (("out", None), ("codec", AUTO), ("certificate", None)):
            if getattr(self, name) != usual and not self.web:
                raise InputError(f"--{name} {getattr(self, name)}: it is for --web; name its address, or leave it out")
        if self.frames is None:
            refuse_without_frames(self.sequence_options, self.repair)


def recordings_field() -> Any:
    """Return the field of the traces of an experiment."""
    return several(
        attrs.fields(RunOptions).trace,
        ("look-around", "walk"),
        name="traces",
        metavar="TRACE",
        positional=True,
        parse=None,
    )


def refuse_one_name(kind: str, called: Mapping[str, str]) -> None:
    """Raise InputError if two share a name: rows, tables and charts distinguish cases by it.

    called: name by option.
    """
    found: dict[str, str] = {}
    for asked, name in called.items():
        first = found.setdefault(name, asked)
        if first != asked:
            raise InputError(
                f"{kind} '{first}' and '{asked}' are both called '{name}': leave one out, or rename a file"
            )

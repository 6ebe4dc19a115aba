"""What a live run is asked to do."""

from __future__ import annotations

from pathlib import Path

import attrs

from ...errors import InputError
from ...pipeline.options import AUTO, PipelineOptions, number

SOURCES = (AUTO_SOURCE, OPENXR, DESKTOP, OFFSCREEN) = ("auto", "openxr", "desktop", "offscreen")
VIEWS = (BOTH, FLAT) = ("both", "flat")


def one_of(name: str, known: tuple[str, ...]):
    def check(_: object, __: attrs.Attribute, value: str) -> None:
        if value not in known:
            raise InputError(f"{name} '{value}': wanted {' or '.join(known)}")

    return check


@attrs.frozen(kw_only=True)
class LiveOptions(PipelineOptions):
    """A live run.

    lens: "auto" for the headset's where a window stands for it, none where a runtime corrects its own. source: where the head and the
    display are; "auto" takes the headset if one answers, else the desktop; "offscreen" shows nobody anything. trace: a recorded head that
    a window or an offscreen display follows, by name or file; "" for a living one. view: in the window, both eyes as the panel gets them
    or one flat view. full_screen, vsync, panel: of the window; panel: whether to show the panel of controls, where its package is there.
    depth_layer: whether a runtime that takes the picture's depth gets it.
    seconds, frames: when to stop by itself; None for never. record: where to write the head's trace while running. out: folder for
    frames.csv, summary.json and report.html; None for none. images_every: keep there every n-th refresh as pictures, just as they were
    handed over; 0 for none. reconnect_s: how long to wait for a lost runtime. hang_s: how long the runtime may keep silent before the run
    is ended. collect: whether Python's garbage collector runs between the pictures instead of whenever it likes.
    Errors: InputError for a number or word that cannot be meant.
    """

    lens: str = AUTO
    source: str = attrs.field(default=AUTO_SOURCE, validator=one_of("source", SOURCES))
    trace: str = ""
    view: str = attrs.field(default=BOTH, validator=one_of("view", VIEWS))
    full_screen: bool = False
    vsync: bool = True
    panel: bool = True
    depth_layer: bool = True
    seconds: float | None = attrs.field(default=None, validator=number("seconds", " s", above=True))
    frames: int | None = attrs.field(default=None, validator=number("frames", least=1))
    record: Path | None = attrs.field(default=None, converter=attrs.converters.optional(Path))
    out: Path | None = attrs.field(default=None, converter=attrs.converters.optional(Path))
    images_every: int = attrs.field(default=0, validator=number("images-every"))
    reconnect_s: float = attrs.field(default=60.0, validator=number("reconnect", " s"))
    hang_s: float = attrs.field(default=5.0, validator=number("hang", " s", least=0.1))
    collect: bool = True
    command: str = ""

    def __attrs_post_init__(self) -> None:
        super().__attrs_post_init__()
        if self.guard == AUTO:
            raise InputError(
                "guard auto looks at the whole trace first, which a live run has not: give a number, or replay a recording"
            )
        if self.source == OFFSCREEN and not self.trace:
            raise InputError("source offscreen: nobody's head leads it; name a recorded one by --trace, such as walk")
        if self.trace and self.source in (AUTO_SOURCE, OPENXR):
            raise InputError(f"trace {self.trace}: a headset has a head of its own; take --source desktop or offscreen")
        if self.warp == AUTO and self.bench is None:
            raise InputError(
                "warp auto in a live run needs a benchmark to choose from: make one by 'hmdwarp bench', give it by --bench"
            )
        if self.images_every and self.out is None:
            raise InputError(
                f"images-every {self.images_every}: there is no folder to keep pictures in; name one by --out"
            )

"""Which display a live run gets, and why."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import AbstractContextManager

from ...display import Display, DisplayOptions
from ...display.controls import CONTROLS, Control
from ...errors import MachineError
from ...poses import load_trace
from .options import DESKTOP, OFFSCREEN, OPENXR, LiveOptions

Watching = Callable[[str], AbstractContextManager[None]]


def open_display(
    options: LiveOptions,
    watching: Watching,
    say: Callable[[str], None],
    controls: tuple[Control, ...] = CONTROLS,
    *,
    briefly: bool = False,
) -> Display:
    """The headset or the window, as asked for; for "auto" the headset if one answers, else the window. say: gets why it is no headset.
    controls: what whoever looks may ask for. briefly: say that in a clause, and leave the rest to the doctor.

    Errors: MachineError (and its kin) that says what is missing and what to do: for "auto" of both.
    """
    wanted = display_options(options, watching, controls)
    if options.source == OFFSCREEN:
        return _offscreen(wanted)
    if options.source == DESKTOP:
        return _desktop(wanted)
    try:
        return _openxr(wanted)
    except MachineError as error:
        why = str(error)
        if options.source == OPENXR:
            raise MachineError(f"{why}; or take a window: --source desktop") from error
    try:
        display = _desktop(wanted)
    except MachineError as error:
        raise MachineError(f"neither headset nor window: {why}; and {error}") from error
    say(f"a window, as there is no headset: {_first_clause(why) if briefly else why}")
    return display


def _first_clause(why: str) -> str:
    return f"{re.split('[:;] ', why, maxsplit=1)[0]} (hmdwarp doctor tells more)"


def display_options(
    options: LiveOptions, watching: Watching, controls: tuple[Control, ...] = CONTROLS
) -> DisplayOptions:
    """What a display must know of the run."""
    return DisplayOptions(
        headset=options.headset,
        view=options.view,
        size=options.size,
        full_screen=options.full_screen,
        vsync=options.vsync,
        control_panel=options.panel,
        depth_layer=options.depth_layer,
        watching=watching,
        trace=load_trace(options.trace).track if options.trace else None,
        rate_hz=options.rate_hz,
        controls=controls,
    )


def _openxr(wanted: DisplayOptions) -> Display:
    from ...display.openxr import OpenXrDisplay

    return OpenXrDisplay(wanted)


def _offscreen(wanted: DisplayOptions) -> Display:
    from ...display.offscreen import OffscreenDisplay

    return OffscreenDisplay(wanted)


def _desktop(wanted: DisplayOptions) -> Display:
    from ...display.desktop import DesktopDisplay

    return DesktopDisplay(wanted)

"""Warp RGB-D frames of a caller: one in one call, or many with what is compiled once."""

from __future__ import annotations

import atexit
import functools
import inspect
import threading
import warnings
import weakref
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from functools import cached_property
from itertools import cycle
from numbers import Integral, Real
from pathlib import Path
from types import MappingProxyType
from typing import Any, Concatenate, NoReturn, ParamSpec, TypeVar

import attrs
import moderngl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import report
from ..client.compensator import Compensator
from ..client.inputs import PassInputs
from ..client.plan import CLIENT_DEPTH, OTHERS, SHOWN_DEPTH, Plan, needs_of
from ..colour import srgb8_from_linear
from ..errors import HmdwarpError, InputError, in_brief
from ..frames import EyeImage
from ..geometry import DepthLayer, View, metres_from_inverse_depth
from ..gpu.context import Gpu, check_not_forked
from ..gpu.textures import SCALAR, Canvas, allocate, check_size, download, upload
from ..gpu.timers import Lap
from ..options import AUTO
from ..pipeline.governor import Change
from ..pipeline.options import DEFAULT_WARP, SINGLE_FILL
from ..scenes import Panel
from ..sources.array_passes import LINEAR, SRGB, SRGB8, GiveOut, PixelBuffers, TakeIn
from ..sources.repairs import parse_repairs
from ..sources.sequences import about_largest, about_unit
from .picture_arrays import (
    RawPicture,
    about_corners,
    about_holes,
    checked_picture,
    checked_size,
    checked_view,
    is_one_of,
    raw_picture,
    without_hidden,
)
from .picture_textures import INVERSE, CallerLayers, ForeignTextures, HeldPicture, with_panel_effects, with_panels
from .usable import AutoCompensator, plan_of, plans_of_levels

_MOST_AGE_S = 9e9  # in nanoseconds still of 64 bits
IN_FLIGHT = 3  # calls of Warper.submit whose pixels are on their way at once
_LARGEST, _UNIT, _CORNERS, _HOLES = "largest", "unit", "corners", "holes"  # what a Warper warns of once
_CLOSED_FIRST = "this Warper was closed before result() was called: call it first"
Other = tuple[ArrayLike, ArrayLike, View]
P = ParamSpec("P")
T = TypeVar("T")
_shared: Gpu | None = None
_turn = threading.RLock()  # a thread that holds it may take it again


@contextmanager
def _shared_gpu() -> Iterator[Gpu]:
    """Lend the shared context to this thread for the duration of the block."""
    global _shared  # noqa: PLW0603 (made late, because importing must not start a GL driver)
    check_not_forked()  # first: in a forked process the lock may be held by a thread that is not there
    with _turn:
        if _shared is None:
            _shared = made = Gpu()
            _shared.step_aside()

            @atexit.register
            def close() -> None:
                if not made.closed:
                    _turn.acquire()  # to the end: a daemon thread that calls now waits, not to outlive its context
                    made.close()

        with _shared.current():
            yield _shared


@attrs.frozen(eq=False)
class WarpedImage:
    """A warped picture; row 0 is at the top."""

    colour: NDArray[Any]  # (h, w, 3), black in holes; see `encoding`
    # (h, w), 0 in holes, else 1, which a fill sets too; with a repair less where the depth that
    # brought the pixel there was a guess: its confidence.
    coverage: NDArray[np.float32]
    # Milliseconds by stage name, "upload", "download" and "host" (all else) included: their sum is
    # the call. Of a chain each fill has its own, such as "fill memory".
    time_ms: dict[str, float]
    hole_share: float  # share of pixels without coverage after the warp and before the fill
    encoding: str = LINEAR  # of the colour: "srgb8" (uint8), "srgb" (float32, 0 to 1) or "linear" (float32)
    depth_m: NDArray[Any] | None = None  # (h, w) metres along -z in the shown view, NaN unknown; None if not requested

    def __repr__(self) -> str:
        high, wide = self.coverage.shape
        share, total_ms = 100 * self.hole_share, sum(self.time_ms.values())
        return f"<WarpedImage: {wide}x{high} {self.encoding}, {share:.1f} % holes before the fill, {total_ms:.2f} ms>"

    def _repr_png_(self) -> bytes:
        """Return the picture as a PNG file: a notebook shows it."""
        colour = self.colour
        if self.encoding == LINEAR:
            colour = srgb8_from_linear(colour)
        elif colour.dtype != np.uint8:
            colour = np.rint(255 * np.clip(colour, 0, 1)).astype(np.uint8)
        return report.png_bytes(np.ascontiguousarray(colour))


@attrs.frozen(eq=False)
class Call:
    """What Warper.warp and submit take; see there."""

    colour: ArrayLike
    depth_m: ArrayLike
    rendered: View
    shown: View
    others: Sequence[Other] = attrs.field(default=(), kw_only=True)
    client_depth_m: ArrayLike | None = attrs.field(default=None, kw_only=True)
    layers: Mapping[str, Any] = attrs.field(default=MappingProxyType({}), kw_only=True)
    panels: Sequence[Panel] | None = attrs.field(default=None, kw_only=True)
    age_s: float = attrs.field(default=0.0, kw_only=True)
    depth_scale: float | None = attrs.field(default=None, kw_only=True)
    encoding: str | None = attrs.field(default=None, kw_only=True)
    result: str | None = attrs.field(default=None, kw_only=True)
    eye: int = attrs.field(default=0, kw_only=True)
    out: Mapping[str, NDArray[Any]] = attrs.field(default=MappingProxyType({}), kw_only=True)

    @cached_property
    def views(self) -> tuple[View, View]:
        """Both views. Errors: InputError."""
        return _checked_views(self.rendered, self.shown, self.eye)

    @cached_property
    def picture(self) -> RawPicture:
        """Colour and depth. Errors: InputError."""
        return raw_picture(without_hidden(self.colour, self.views[0]), self.depth_m, self.depth_scale, self.encoding)

    @cached_property
    def further(self) -> list[tuple[RawPicture, View]]:
        """The other pictures. Errors: InputError."""
        found = []
        for number, other in enumerate(self.others):
            try:
                colour, depth_m, view = other
            except (TypeError, ValueError) as error:
                raise InputError(f"others[{number}]: expected (colour, depth_m, view)") from error
            picture = raw_picture(colour, depth_m, self.depth_scale, self.encoding)
            found.append((picture, checked_view(f"others[{number}]", view)))
        return found

    def check(self) -> None:
        """Check the rest of what needs no Warper. Errors: InputError."""
        for name, kind, expected in (
            ("others", Sequence, "a list of (colour, depth_m, view), or () for none"),
            ("out", Mapping, 'a dict of arrays by the name of a result, such as {"colour": array}'),
        ):
            if not isinstance(getattr(self, name), kind):
                raise InputError(f"{name} is of type {type(getattr(self, name)).__name__}: expected {expected}")
        known = SRGB8, SRGB, LINEAR
        if not is_one_of(self.result, known):
            expected = f"{', '.join(known)}, or None for that of the picture"
            raise InputError(f"result is {in_brief(self.result)}: expected {expected}")
        age_s = self.age_s
        if isinstance(age_s, bool) or not isinstance(age_s, Real) or not abs(age_s) <= _MOST_AGE_S:
            raise InputError(f"age_s is {in_brief(age_s)}: expected seconds from drawing the picture to showing it")


def _taking(kind: Callable[P, Call]) -> Callable[[Callable[[Any, Call], T]], Callable[Concatenate[Any, P], T]]:
    """Return a decorator for methods of a call: they take its parts."""

    def decorated(method: Callable[[Any, Call], T]) -> Callable[Concatenate[Any, P], T]:
        def of_parts(warper: Any, /, *parts: P.args, **named: P.kwargs) -> T:
            try:
                call = kind(*parts, **named)
            except TypeError as error:
                raise TypeError(str(error).replace("Call.__init__", f"Warper.{method.__name__}")) from None
            return method(warper, call)

        functools.update_wrapper(of_parts, method)
        (warper, _), given = inspect.signature(method).parameters.values(), inspect.signature(kind)
        signature = given.replace(parameters=[warper, *given.parameters.values()])
        of_parts.__signature__ = signature  # type: ignore[attr-defined]
        return of_parts

    return decorated


@attrs.define(eq=False)
class _Flight:
    """A call that the GPU has, or has not yet, done."""

    call: Call
    pictures: list[RawPicture]
    result: str  # the encoding of the result
    buffers: PixelBuffers
    plan: Plan  # what has run
    made: dict[str, moderngl.Buffer] = attrs.field(factory=dict)  # what of the buffers has the result, by name
    late: bool = False  # whether the caller's arrays may hold other pictures by now


class Pending:
    """A picture of Warper.submit, on its way."""

    def __init__(self, warper: Warper, answer: HmdwarpError | None = None) -> None:
        self._warper = warper
        self._answer: WarpedImage | HmdwarpError | None = answer
        # Until there is an answer: the call, what submit() took, and its stages.
        self._on_its_way: tuple[_Flight, float, Lap] | None = None

    def result(self) -> WarpedImage:
        """Return what warp() returns, waiting for the GPU; the same again each time.

        Its `time_ms` has what submit() and this took: `upload`, `download`, `wait` (for the GPU)
        and `host` (all else), and passes where the GPU has a clock of its own. Errors: as warp;
        InputError where the Warper was closed first.
        """
        if self._answer is None:
            with self._warper._gpu() as gpu:
                self._warper._fetch(gpu, self)
        if not isinstance(self._answer, WarpedImage):
            raise self._answer or AssertionError("it was fetched")
        return self._answer


@attrs.frozen(eq=False)
class WarpedTextures:
    """A warped picture on the GPU; rows run bottom to top, as OpenGL has them.

    The textures belong to the Warper, which overwrites them at the next picture of the same eye.
    """

    colour: moderngl.Texture  # rgba16f: linear light, coverage in alpha, 0 in holes
    inverse_depth: moderngl.Texture | None  # r32f in 1/m in the shown view, -1 unknown; None unless asked for
    _warper: Warper = attrs.field(repr=False)  # keeps the textures


class Warper:
    """Warp pictures with depth, one after the other, into views of one size.

    Compiles and allocates at the start. Use as a context manager, or call close(): then any call is
    an InputError. What one holds that is dropped without it is freed by the next call of another
    Warper of its context. OpenGL does not survive a fork: see warp_image.

    Parameters
    ----------
    size : (w, h)
        Of the results, in pixels.
    rendered_size : (w, h), optional
        Of the pictures; by default the same.
    warp, fill, effects, repair : str
        As warp_image. Fill "memory+pyramid", that of runs, learns from each picture.
    depth : bool
        Whether results have the depth of what is shown.
    gpu : Gpu, optional
        A context made in the calling thread, which then makes all calls; by default one is shared
        with all threads, one at a time. Take `Gpu(moderngl.create_context(require=430))` for the
        OpenGL context that is current: then your textures can be read without a copy, and you bind
        your own state again after each call.
    budget_ms, bench : float, path
        As warp_image, for warp "auto", which keeps warp and fill within budget_ms a picture: `plan`
        is that of the last one.

    Raises
    ------
    InputError, PlanError, UnknownNameError, MachineError
        As warp_image.
    """

    def __init__(
        self,
        size: tuple[int, int],
        *,
        rendered_size: tuple[int, int] | None = None,
        warp: str = DEFAULT_WARP,
        fill: str = SINGLE_FILL,
        effects: str = "none",
        repair: str = "none",
        depth: bool = False,
        gpu: Gpu | None = None,
        budget_ms: float | None = None,
        bench: Path | str | None = None,
    ) -> None:
        if gpu is not None and not isinstance(gpu, Gpu):
            raise InputError(f"gpu is of type {type(gpu).__name__}: expected a hmdwarp.gpu.Gpu, as Gpu(context) is")
        self._own_gpu, self._count, self._thread = gpu, 0, threading.get_ident()
        self._warned: set[str] = set()
        auto = plans_of_levels(bench, effects, depth, budget_ms) if isinstance(warp, str) and warp == AUTO else None
        plans = [plan_of(warp, fill, effects, depth=depth)] if auto is None else [*auto.values()]
        if auto is None and not (budget_ms is None and bench is None):
            raise InputError(f"budget_ms and bench are for warp 'auto': '{warp}' takes what it takes; leave them out")
        self._needs, self._has_depth = needs_of(plans), depth
        self._learns = any(choice.entry.remembers for plan in plans for choice in plan.fills)
        self.repair = parse_repairs(repair)
        self.size = checked_size(size)
        self.rendered_size = self.size if rendered_size is None else checked_size(rendered_size)
        with self._context() as current, ExitStack() as stack:
            check_size(current.gl, self.rendered_size)
            check_size(current.gl, self.size)
            sizes = self.rendered_size, self.size
            self._compensator: Compensator | AutoCompensator
            if auto is None:
                self._compensator = Compensator(current, plans[0], None, *sizes)
            else:
                self._compensator = AutoCompensator(current, auto, *sizes, budget_ms or 0)
            stack.callback(self._compensator.close)
            self._foreign = ForeignTextures(current, self.rendered_size)
            self._layers = CallerLayers(current, self._needs, self.rendered_size, self.size)
            stack.callback(self._layers.close)
            self._client_depth = None
            if self.plan.reads(CLIENT_DEPTH):
                self._client_depth = allocate(current.gl, self.size, SCALAR)
                stack.callback(self._client_depth.release)
            count = 1 + self._needs.others.count + self._needs.others.recent
            has_confidence = bool(self.repair.steps)
            self._pictures = [HeldPicture(current, self.rendered_size, has_confidence) for _ in range(count)]
            for picture in self._pictures:
                stack.callback(picture.close)
            self._take_in, self._give_out = TakeIn(current, self.rendered_size), GiveOut(current, self.size)
            for passes in (self._take_in, self._give_out):
                stack.callback(passes.close)
            # Those that no call has, and the calls that have the rest.
            self._free_buffers: list[PixelBuffers] = []
            self._in_flight: deque[Pending] = deque()
            self._confidence = Canvas(current.gl, self.size) if has_confidence else None
            if self._confidence is not None:
                stack.callback(self._confidence.release)
            self._cleanup = stack.pop_all()
        self._dropped = weakref.finalize(self, current.free_later, self._cleanup.close)
        self._dropped.atexit = False

    @_taking(Call)
    def warp(self, call: Call) -> WarpedImage:
        """Return the view `shown`, warped from a picture with depth drawn for `rendered`.

        Parameters
        ----------
        colour, depth_m, rendered, shown, others, client_depth_m, layers, panels, age_s, depth_scale
        encoding, result
            As warp_image; panels are for a Warper with effects="panels" (or, to be hidden by what
            is nearer, "panels,occluded_panels").
        eye : int
            0 or 1; a fill that remembers keeps the two apart.
        out : mapping
            Arrays of yours for the result by name (colour, coverage, depth_m), of any strides:
            uint8, or floats of any width; what it lacks is allocated.

        Returns
        -------
        WarpedImage

        Raises
        ------
        InputError
            As warp_image, and for a closed Warper.
        """
        with self._gpu() as gpu:
            gpu.timer.collect()
            return self._ended(gpu, self._begun(gpu, call), 4)

    @_taking(Call)
    def submit(self, call: Call) -> Pending:
        """Begin what warp() does with the same arguments, and return before the GPU has done it.

        The arrays are read before this returns; those of `out` are written by result(). Pixels of
        three calls are on their way at most: a fourth first fetches the result of the oldest.

        Raises
        ------
        InputError
            For a closed Warper; result() raises all others.
        """
        with self._gpu() as gpu:
            if len(self._in_flight) == IN_FLIGHT:
                self._fetch(gpu, self._in_flight[0], 5)
            gpu.timer.lap()
            try:
                # Passes that the wall clock times for "auto" are waited for.
                is_timed = isinstance(self._compensator, AutoCompensator) and gpu.timer.clock == "wall"
                with nullcontext() if is_timed else gpu.timer.without_waiting():
                    flight = self._begun(gpu, call)
            except HmdwarpError as error:
                return Pending(self, error)
            pending, spent_ms = Pending(self), gpu.timer.lap_ms
            pending._on_its_way = flight, spent_ms, gpu.timer.lap()
            self._in_flight.append(pending)
            return pending

    def warp_each(self, frames: Iterable[Mapping[str, Any]]) -> Iterator[WarpedImage]:
        """Yield what warp() makes of each frame, in order, while the next two are on their way.

        Parameters
        ----------
        frames : iterable of mappings
            Arguments of warp by name; an error comes in the place of the frame.
        """
        pending: deque[Pending] = deque()
        for frame in frames:
            pending.append(self.submit(**frame))
            if len(pending) == IN_FLIGHT:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()

    def _begun(self, gpu: Gpu, call: Call) -> _Flight:
        """Send the pictures, and let the GPU make the result. Errors: as warp."""
        picture, views, layers = call.picture, call.views, with_panels(call.layers, call.panels)
        call.check()
        result = picture.encoding if call.result is None else call.result
        pictures = [picture, *(one for one, _ in call.further)]
        for number, one in enumerate(pictures):
            if one.size != self.rendered_size:
                (found_wide, found_high), (wide, high) = one.size, self.rendered_size
                name = f"others[{number - 1}]: " if number else ""
                raise InputError(f"{name}colour is {found_wide}x{found_high} pixels: this Warper is for {wide}x{high}")
        self._check_needs(len(call.further), call.client_depth_m is not None)
        self._layers.check(layers, self._named)
        self._check_out(call.out, result)
        client = None
        if call.client_depth_m is not None:
            if (shape := np.shape(call.client_depth_m)) != self.size[::-1]:
                raise InputError(f"client_depth_m has shape {shape}: expected {self.size[::-1]}, as the result")
            grey = np.zeros((*shape, 3), np.uint8)
            client = checked_picture(grey, call.client_depth_m, call.depth_scale).arrays()[1]
        self._count += 1
        if self.repair.steps:
            pictures = [one.as_checked().raw() for one in pictures]
        images = [
            EyeImage(view, *textures.pair, drawn_ns=self._count)
            for textures, view in zip(self._pictures, (views[0], *(view for _, view in call.further)), strict=False)
        ]
        if not self._free_buffers:
            self._free_buffers.append(PixelBuffers(gpu, len(self._pictures)))
            self._cleanup.callback(self._free_buffers[-1].close)
        flight = _Flight(call, pictures, result, self._free_buffers.pop(), self.plan)
        try:
            self._upload(flight, gpu)
            if self._learns:
                flight.buffers.found.read()
                self._check_numbers(flight)
            with gpu.timer.cpu_stage("upload"):
                images[0] = images[0].having(**self._layers.hold(layers))
                if client is not None and self._client_depth is not None:
                    upload(self._client_depth, client)
            inputs = self._inputs(images, views[1], call.eye, round(float(call.age_s) * 1e9))
            made = self._compensator.run(inputs)
            flight.plan = self.plan
            if self._confidence is not None:
                held = {picture.pair[0]: picture.sure for picture in self._pictures}
                self._compensator.carry(inputs, lambda image: held[image.colour], self._confidence)
            assert made.shown is not None and made.warped is not None, "only a fused plan lacks them"
            depth = made.inverse_depth if self._has_depth else None
            with gpu.timer.cpu_stage("download"):
                flight.made = self._give_out.run(
                    made.shown, made.warped, depth, self._confidence, flight.result, flight.buffers
                )
        except BaseException:
            self._free_buffers.append(flight.buffers)
            raise
        return flight

    def _ended(self, gpu: Gpu, flight: _Flight, frames: int = 3) -> WarpedImage:
        """Return the result, and free the buffers of the call. Errors: as warp.

        frames: from where a warning is given to the caller.
        """
        try:
            with gpu.timer.cpu_stage("wait") if flight.late else nullcontext():
                flight.buffers.found.read()
            gpu.check_not_lost()
            self._check_numbers(flight)
            share = flight.buffers.found.holes / (self.size[0] * self.size[1])
            for note in self._notes(flight, share):
                warnings.warn(note, stacklevel=frames)
            with gpu.timer.cpu_stage("download"):
                arrays = self._give_out.arrays(flight.made, flight.call.out)
        finally:
            self._free_buffers.append(flight.buffers)
        times: dict[str, float] = {}
        if not flight.late:
            whole_ms = gpu.timer.lap_ms
            times = self._recorded(flight, gpu.timer.collect())
            times["host"] = max(whole_ms - sum(times.values()), 0.0)  # their sum is the call
        return WarpedImage(arrays["colour"], arrays["coverage"], times, share, flight.result, arrays.get("depth_m"))

    def _fetch(self, gpu: Gpu, pending: Pending, level: int = 4) -> None:
        """Make the answer of a call, unless another thread has. level: of stack, to the caller."""
        if pending._on_its_way is None:
            return
        (flight, spent_ms, lap), pending._on_its_way = pending._on_its_way, None
        self._in_flight.remove(pending)
        flight.late = True
        gpu.timer.lap()
        try:
            with gpu.timer.without_waiting():
                image = self._ended(gpu, flight, level)
        except HmdwarpError as error:
            pending._answer = error
            return
        spent_ms += gpu.timer.lap_ms
        times = self._recorded(flight, (*lap.read(), *gpu.timer.lap().read()))
        own_ms = sum(times.get(name, 0.0) for name in ("upload", "repair", "wait", "download"))
        pending._answer = attrs.evolve(image, time_ms={**times, "host": max(spent_ms - own_ms, 0.0)})

    def _upload(self, flight: _Flight, gpu: Gpu) -> None:
        """Take pictures over, their depth repaired."""
        flight.buffers.found.clear()
        for number, (textures, one) in enumerate(zip(self._pictures, flight.pictures, strict=False)):
            mended = one
            if self.repair.steps:
                with gpu.timer.cpu_stage("repair"):
                    mended, confidence = one.as_checked().repaired(self.repair)
                textures.hold_confidence(confidence)
            with gpu.timer.cpu_stage("upload"):
                sent = self._take_in.send(mended, flight.buffers, number)
                self._take_in.run(mended, sent, textures.pair, flight.buffers.found, number)

    def _picture(self, flight: _Flight, number: int) -> RawPicture:
        """Return a picture with the numbers that the GPU was sent."""
        picture = flight.pictures[number]
        if not flight.late or picture.checked is not None:
            return picture
        return picture.as_sent(*self._take_in.sent(picture, flight.buffers, number))

    def _check_numbers(self, flight: _Flight) -> None:
        """Check what the GPU has noted of their numbers. Errors: InputError as checked_picture."""
        for number in range(len(flight.pictures)):
            if flight.buffers.found.is_doubtful(number, self.rendered_size):
                self._picture(flight, number).as_checked()

    def _check_out(self, out: Mapping[str, NDArray[Any]], result: str) -> None:
        """Check the arrays that a result is written into. Errors: InputError."""
        high, wide = self.size[1], self.size[0]
        shapes = {"colour": (high, wide, 3), "coverage": (high, wide)}
        shapes |= {"depth_m": (high, wide)} if self._has_depth else {}
        for name, array in out.items():
            if name not in shapes:
                raise InputError(f"out names '{name}': expected some of {', '.join(shapes)}")
            kind = "uint8" if name == "colour" and result == SRGB8 else "floats"
            if not isinstance(array, np.ndarray):
                raise InputError(f"out['{name}'] is a {type(array).__name__}: expected an array of {kind}")
            if array.shape != shapes[name] or (array.dtype != np.uint8 if kind == "uint8" else array.dtype.kind != "f"):
                raise InputError(
                    f"out['{name}'] is {array.dtype} {array.shape}: expected {kind} of shape {shapes[name]}"
                )
            if not array.flags.writeable:
                raise InputError(f"out['{name}'] is read-only: expected an array that can be written into")

    def warp_textures(
        self,
        colour: moderngl.Texture,
        depth: moderngl.Texture,
        rendered: View,
        shown: View,
        *,
        depth_as: str | DepthLayer = INVERSE,
        encoding: str = LINEAR,
        panels: Sequence[Panel] | None = None,
        eye: int = 0,
    ) -> WarpedTextures:
        """Return the view `shown` as textures, from textures of the same context.

        Warns once of depth that is hardly in metres, as warp_image does: it is read back for the
        first picture whose eye moves.

        Parameters
        ----------
        colour, depth : moderngl.Texture
            Of rendered_size, rows bottom to top; `gpu.gl.external_texture` makes one of an OpenGL
            id. Alpha is coverage: 0 is a hole. rgba16f colour in linear light beside r32f inverse
            depth are read where they are; all else is taken over by one pass.
        rendered, shown : View
            As warp_image.
        depth_as : str or DepthLayer
            "inverse" (1/m; below 0 is none), "metres" (0 is none), or the DepthLayer of a buffer.
        encoding : str
            "linear", also for a texture that OpenGL decodes itself, or "srgb".
        panels, eye
            As warp.

        Raises
        ------
        InputError
            For arguments that do not fit, for a warp that reads more than a picture with depth, and
            for a Warper with a repair, which runs on arrays.
        """
        views = _checked_views(rendered, shown, eye)
        self._check_needs(0, client_depth=False)
        laid = with_panels({}, panels)
        self._layers.check(laid, f"{self._named} runs on arrays where it")
        if isinstance(self._compensator, AutoCompensator):
            raise InputError("warp 'auto' times pictures of warp() and submit(): name a warp for textures")
        if self.repair.steps:
            raise InputError(f"repair '{self.repair.text}' runs on arrays: give them to warp(), or leave it out")
        if self._own_gpu is None:
            raise InputError("textures belong to a context: make the Warper with gpu=, the context they are of")
        with self._gpu() as gpu:
            pair = self._foreign.converted(colour, depth, depth_as, encoding, self._pictures[0].pair)

            def metres() -> NDArray[np.float64]:  # read back once: it waits for the GPU
                inverse = download(pair[1])
                return metres_from_inverse_depth(np.where(inverse >= 0, inverse, np.nan).astype(np.float64))

            for note in self._unit_notes(metres, views, "a scale of {:g}"):
                warnings.warn(note, stacklevel=2)
            self._count += 1
            image = EyeImage(views[0], *pair, self._layers.hold(laid), drawn_ns=self._count)
            made = self._compensator.run(self._inputs([image], views[1], eye))
            gpu.check_not_lost()
            assert made.shown is not None, "only a fused plan lacks it"
            return WarpedTextures(made.shown.texture, made.inverse_depth, self)

    @property
    def plan(self) -> Plan:
        """The passes of the last picture."""
        return self._compensator.plan

    @property
    def changes(self) -> tuple[Change, ...]:
        """What warp "auto" has switched, and why."""
        return self._compensator.changes if isinstance(self._compensator, AutoCompensator) else ()

    @property
    def time_ms(self) -> dict[str, float]:
        """Milliseconds by stage of the pictures since this was last read; waits for the GPU."""
        with self._gpu() as gpu:
            return self._summed(gpu.timer.collect(), self.plan)

    def _recorded(self, flight: _Flight, stages: Iterable[tuple[str, float]]) -> dict[str, float]:
        times = self._summed(stages, flight.plan)
        if isinstance(self._compensator, AutoCompensator):
            self._compensator.record(flight.call.eye, times)
        return times

    @staticmethod
    def _summed(stages: Iterable[tuple[str, float]], plan: Plan) -> dict[str, float]:
        """Return milliseconds by stage name, all pictures of a plan together; see WarpedImage."""
        names = [f"fill {choice.entry.name}" for choice in plan.fills] if len(plan.fills) > 1 else ["fill"]
        if len(names) > 1 and plan.warps_twice:
            fills_depth = any(step.stage == "fill" and SHOWN_DEPTH in step.writes for step in plan.steps)
            names = ["fill depth", *names] if fills_depth else names
        fills, total = cycle(names), dict[str, float]()
        for stage, milliseconds in stages:
            name = next(fills) if stage == "fill" else stage
            total[name] = total.get(name, 0.0) + milliseconds
        return total

    def close(self) -> None:
        """Free all textures and buffers; nothing after the first time, and in a forked process."""
        gpu = _shared if self._own_gpu is None else self._own_gpu
        if self._dropped.alive and gpu is not None and not gpu.closed:
            with self._context():
                while self._in_flight:
                    pending = self._in_flight.popleft()
                    pending._on_its_way, pending._answer = None, InputError(_CLOSED_FIRST)
                self._dropped.detach()
                self._cleanup.close()

    def __enter__(self) -> Warper:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __reduce__(self) -> NoReturn:
        raise InputError("a Warper cannot be copied or sent to another process: make one there")

    @contextmanager
    def _gpu(self) -> Iterator[Gpu]:
        with self._context() as gpu:
            if not self._dropped.alive:
                raise InputError("this Warper is closed: make another")
            yield gpu

    def _context(self) -> AbstractContextManager[Gpu]:
        if self._own_gpu is None:
            return _shared_gpu()
        if threading.get_ident() != self._thread:
            raise InputError("this Warper was made in another thread, with a context of that thread: call it there")
        return self._own_gpu.current()

    def _notes(self, flight: _Flight, hole_share: float) -> Iterator[str]:
        """Yield what to warn of: depth that is none, or hardly in metres, no picture; each once."""
        if _LARGEST not in self._warned:
            checked, largest = flight.pictures[0].checked, list[str]()
            if checked is not None:
                largest += checked.notes
            elif flight.buffers.found.has_largest(0):
                largest += about_largest([self._picture(flight, 0).depth])
            self._warned.update([_LARGEST] if largest else [])
            yield from largest
        yield from self._unit_notes(lambda: self._picture(flight, 0).metres(), flight.call.views, "depth_scale={:g}")
        if _CORNERS not in self._warned:  # of the first picture
            self._warned.add(_CORNERS)
            yield from about_corners(self._picture(flight, 0))
        if flight.plan.fills and _HOLES not in self._warned:  # where nothing fills holes, coverage tells of them
            empty = about_holes(hole_share, *flight.call.views)
            self._warned.update([_HOLES] if empty else [])
            yield from empty

    def _unit_notes(self, depth: Callable[[], NDArray[Any]], views: tuple[View, View], option: str) -> list[str]:
        """Return a note on depth (metres, called for once) at the first picture whose eye moves."""
        moved_m = float(np.linalg.norm(views[1].pose.position_m - views[0].pose.position_m))
        if _UNIT in self._warned or not moved_m:
            return []
        self._warned.add(_UNIT)
        return about_unit([depth()], moved_m, option)

    @property
    def _named(self) -> str:
        return f"warp '{self.plan.choice}'" + "".join(f" with effect '{name}'" for name in self.plan.effects)

    def _check_needs(self, others: int, client_depth: bool) -> None:
        """Check that the plan gets what it reads, and nothing that it does not."""
        named, most = self._named, self._needs.others.count + self._needs.others.recent
        if most and not others and self.plan.reads(OTHERS):
            raise InputError(f"{named} reads other pictures: give others=[(colour, depth_m, view), ..], at most {most}")
        if others > most:
            reads = f"reads at most {most}" if most else "reads none"
            raise InputError(f"others has {others} pictures, and {named} with fill '{self.plan.fill}' {reads}")
        reads_depth = self.plan.reads(CLIENT_DEPTH)
        if client_depth and not reads_depth:
            raise InputError(f"client_depth_m: {named} does not read it; leave it out, or choose warp 'backward'")
        if reads_depth and not client_depth:
            raise InputError(f"{named} reads the depth of the shown view: give client_depth_m, (h, w) metres")

    def _inputs(self, images: list[EyeImage], shown: View, eye: int, age_ns: int = 0) -> PassInputs:
        depth, shown_ns, count = self._client_depth, self._count + age_ns, 1 + self._needs.others.count
        others, recent = tuple(images[1:count]), tuple(images[count:])
        return PassInputs(images[0], shown, eye, others, recent, client_inverse_depth=depth, shown_ns=shown_ns)


def _checked_views(rendered: object, shown: object, eye: int) -> tuple[View, View]:
    if not isinstance(eye, Integral) or eye not in (0, 1):
        raise InputError(f"eye is {in_brief(eye)}: expected 0 (left) or 1 (right)")
    return checked_view("rendered", rendered), checked_view("shown", shown)


def warp_image(
    colour: ArrayLike,
    depth_m: ArrayLike,
    rendered: View,
    shown: View,
    warp: str = DEFAULT_WARP,
    fill: str = SINGLE_FILL,
    size: tuple[int, int] | None = None,
    gpu: Gpu | None = None,
    *,
    effects: str = "none",
    repair: str = "none",
    others: Sequence[Other] = (),
    client_depth_m: ArrayLike | None = None,
    layers: Mapping[str, Any] = MappingProxyType({}),
    panels: Sequence[Panel] | None = None,
    age_s: float = 0.0,
    depth_scale: float | None = None,
    encoding: str | None = None,
    result: str | None = None,
    depth: bool = False,
    budget_ms: float | None = None,
    bench: Path | str | None = None,
) -> WarpedImage:
    """Return the view `shown`, warped from a picture with depth drawn for `rendered`.

    For many pictures of one size take a Warper, which compiles and allocates once. A process forked
    after the first call cannot use OpenGL: take multiprocessing's "spawn" or "forkserver", or fork
    before. Warns of the largest integer in depth, of depth that is hardly in metres (over 40 m
    everywhere, while the eye moves by less than a tenth of that, or within 1 and crowded there, as
    a depth buffer's), and of a result that is empty before the fill.

    Parameters
    ----------
    colour : (h, w, 3) or (h, w, 4) array_like
        uint8 sRGB or float linear light, row 0 at the top; see `encoding`. A fourth channel is
        coverage: 0 is a hole, all else is seen.
    depth_m : (h, w) array_like
        Metres along -z; inf is infinitely far; 0, negative or NaN marks a hole, which is counted
        and never spread. A pixel that a numpy.ma mask hides, in colour or depth, is a hole too.
    rendered, shown : View
        The view that the picture was drawn for, and that of the result. What rendered.hidden has is
        a hole; what shown.hidden has is black.
    warp : str
        Name of a warp that one picture is enough for. "auto" takes the most accurate warp and fill
        that warp and fill this picture in budget_ms.
    fill : str
        Name of a fill, or several with +; by default "pyramid". The "memory+pyramid" of runs would
        show one frame in the holes of another, for frames of a caller need not follow each other.
    size : (w, h), optional
        Of the result; by default that of `colour`.
    gpu : Gpu, optional
        A context made in the calling thread; by default one is made at the first call and shared by
        all threads, one at a time.
    effects : str
        Names of effects that pictures are enough for, such as "reflections_from_pictures".
    repair : str
        What mends the depth first, such as "edges+complete"; then a pixel shown by guessed depth
        has the confidence of the guess as its coverage.
    others : sequence of (colour, depth_m, view)
        Further pictures of the scene, for warps and effects that read them: the other eye's, then
        older ones, newest first.
    client_depth_m : (h, w) array_like, optional
        Metres in the shown view, for warps that read it.
    layers : mapping
        Further layers by name, for effects and warps that read them: velocity, ids, overlay,
        peeled, transparent; docs/rgbd.md says what each holds.
    panels : sequence of Panel, optional
        Text and menus, laid over the result at its own pose; the first picture of each is shown,
        and is uploaded once for all panels that attrs.evolve makes of one.
    age_s : float
        Seconds from drawing the picture to showing it, for what moves.
    depth_scale : float, optional
        Metres per unit of depth, at most 1, which integers must have: 0.001 for millimetres. The
        largest of their type, such as 65535, is a hole.
    encoding : str, optional
        "linear" or "srgb" (0..1) of float colour; by default it is linear, and values that look
        like 8 bits as floats are refused.
    result : str, optional
        "srgb8" (uint8), "srgb" or "linear" (float32); by default as `colour` is.
    depth : bool
        Whether the result has the depth of what is shown.
    budget_ms : float, optional
        For warp "auto".
    bench : path, optional
        The bench.json of `hmdwarp bench` that warp "auto" chooses from; by default a few are known.

    Returns
    -------
    WarpedImage

    Raises
    ------
    InputError
        For arguments that do not fit, and in a process forked after the first call.
    PlanError
        For a warp that needs more than such pictures.
    UnknownNameError
        For a name that no registry holds.
    MachineError
        Without OpenGL 4.3.
    """
    effects = with_panel_effects(effects, panels)
    more: dict[str, Any] = {"depth_scale": depth_scale, "encoding": encoding, "result": result, "age_s": age_s}
    more |= {"others": others, "client_depth_m": client_depth_m, "layers": layers, "panels": panels}
    asked = Call(colour, depth_m, rendered, shown, **more)
    own_size = asked.picture.size
    asked.check()
    shown_size = own_size if size is None else checked_size(size)
    options: dict[str, Any] = {"warp": warp, "fill": fill, "effects": effects, "repair": repair, "depth": depth}
    options |= {"budget_ms": budget_ms, "bench": bench}
    with Warper(shown_size, rendered_size=own_size, gpu=gpu, **options) as warper, warper._gpu() as current:
        current.timer.collect()
        return warper._ended(current, warper._begun(current, asked))

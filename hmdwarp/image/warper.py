"""Warp RGB-D frames of a caller: one in one call, or many with what is compiled once."""

from __future__ import annotations

import atexit
import threading
import warnings
import weakref
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import partial
from numbers import Integral, Real
from types import MappingProxyType
from typing import Any, NoReturn

import attrs
import moderngl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import report
from ..base import AUTO, InputError, in_brief, srgb8_from_linear
from ..client import Compensator, PassInputs
from ..client.plan import OTHERS, Plan, needs_of
from ..frames import EyeImage
from ..geometry import View
from ..gpu.context import Gpu, check_not_forked
from ..gpu.textures import COLOUR, SCALAR, Canvas, Owner, allocate, check_size, upload
from ..pipeline.governor import check_budget
from ..pipeline.options import DEFAULT_WARP, SINGLE_FILL
from ..sources.array_passes import LINEAR, SRGB, SRGB8, GiveOut, PixelBuffers, TakeIn
from ..sources.repairs import parse_repairs
from ..sources.sequences import about_largest, about_unit
from .picture_arrays import CallerPicture, about_holes, check_view, checked_size, is_one_of, raw_picture
from .picture_textures import CallerLayers
from .usable import LEVELS, chosen, plan_of

_MOST_AGE_S = 9e9  # in nanoseconds still of 64 bits
_LARGEST, _UNIT, _HOLES = "largest", "unit", "holes"  # what a Warper warns of once
Other = tuple[ArrayLike, ArrayLike, View]
Picture = tuple[CallerPicture, View]
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
    # the call.
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
    budget_ms : float
        As warp_image, for warp "auto", which times its levels on the first picture and stays with
        the best: `plan` says which.

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
    ) -> None:
        if gpu is not None and not isinstance(gpu, Gpu):
            raise InputError(f"gpu is of type {type(gpu).__name__}: expected a hmdwarp.gpu.Gpu, as Gpu(context) is")
        self._own_gpu, self._count, self._thread = gpu, 0, threading.get_ident()
        self._warned: set[str] = set()
        self._level = 2  # of the caller of warp, in whose name it warns
        levels = LEVELS if isinstance(warp, str) and warp == AUTO else ()
        auto = {level: plan_of(level.warp, level.fill, effects, depth=depth) for level in levels}
        plans = [*auto.values()] or [plan_of(warp, fill, effects, depth=depth)]
        if auto and budget_ms is None:
            raise InputError("warp 'auto' keeps to a budget: give budget_ms, for the warp and fill of a picture")
        if auto:
            check_budget(budget_ms, "budget_ms")
        elif budget_ms is not None:
            raise InputError(f"budget_ms is for warp 'auto': '{warp}' takes what it takes; leave it out")
        self.plan: Plan = plans[0]  # the passes that run; for warp "auto" those chosen on the first picture
        self._needs, self._has_depth = needs_of(plans), depth
        self._learns = any(choice.entry.remembers for plan in plans for choice in plan.fills)
        self.repair = parse_repairs(repair)
        self.size = checked_size(size)
        self.rendered_size = self.size if rendered_size is None else checked_size(rendered_size)
        with self._context() as current, ExitStack() as stack:
            check_size(current.gl, self.rendered_size)
            check_size(current.gl, self.size)
            self._owner = Owner()
            stack.callback(self._owner.close)
            own, sizes = self._owner.own, (self.rendered_size, self.size)
            self._compensator = own(Compensator(current, self.plan, None, *sizes)) if not auto else None
            self._choose = partial(chosen, current, auto, sizes, budget_ms)
            self._layers = own(CallerLayers(current, self._needs, self.rendered_size))
            count = 1 + self._needs.others.count + self._needs.others.recent
            texture = partial(allocate, current.gl, self.rendered_size)
            self._pairs = [(own(texture(COLOUR)), own(texture(SCALAR))) for _ in range(count)]
            # How sure the depth of each is, with a repair: confidence in red, coverage in alpha.
            self._sure = [own(texture(COLOUR)) for _ in range(count if self.repair.steps else 0)]
            self._take_in, self._give_out = own(TakeIn(current, sizes[0])), own(GiveOut(current, self.size))
            self._buffers = own(PixelBuffers(current, count))
            self._confidence = own(Canvas(current.gl, self.size)) if self.repair.steps else None
            stack.pop_all()
        self._dropped = weakref.finalize(self, current.free_later, self._owner.close)
        self._dropped.atexit = False

    def warp(
        self,
        colour: ArrayLike,
        depth_m: ArrayLike,
        rendered: View,
        shown: View,
        *,
        others: Sequence[Other] = (),
        layers: Mapping[str, Any] = MappingProxyType({}),
        age_s: float = 0.0,
        depth_scale: float | None = None,
        encoding: str | None = None,
        result: str | None = None,
        eye: int = 0,
    ) -> WarpedImage:
        """Return the view `shown`, warped from a picture with depth drawn for `rendered`.

        Parameters
        ----------
        colour, depth_m, rendered, shown, others, layers, age_s, depth_scale, encoding, result
            As warp_image.
        eye : int
            0 or 1; a fill that remembers keeps the two apart.

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
            _check_call(rendered, shown, eye, age_s, result, others)
            pictures = self._pictures_of([(colour, depth_m, rendered), *others], depth_scale, encoding)
            self._check_others(len(pictures) - 1)
            self._layers.check(layers, self._named)
            kind, found = pictures[0][0].encoding if result is None else result, self._buffers.found
            self._count += 1
            if self.repair.steps:
                pictures = [(picture.checked(), view) for picture, view in pictures]
            found.clear()
            for number, (pair, (picture, _)) in enumerate(zip(self._pairs, pictures, strict=False)):
                mended = picture
                if self.repair.steps:
                    with gpu.timer.cpu_stage("repair"):
                        mended, confidence = picture.repaired(self.repair)
                    nothing = np.zeros_like(confidence)
                    upload(self._sure[number], np.stack([confidence, nothing, nothing, confidence > 0], axis=2))
                with gpu.timer.cpu_stage("upload"):
                    sent = self._take_in.send(mended, self._buffers, number)
                    self._take_in.run(mended, sent, pair, found, number)
            if self._learns:
                self._check_numbers(pictures)
            each = zip(self._pairs, pictures, strict=False)
            images = [EyeImage(view, *pair, drawn_ns=self._count) for pair, (_, view) in each]
            with gpu.timer.cpu_stage("upload"):
                images[0] = images[0].having(**self._layers.hold(layers))
            inputs = self._inputs(images, shown, eye, round(float(age_s) * 1e9))
            if self._compensator is None:
                self._compensator = self._owner.own(self._choose(inputs))
                self.plan = self._compensator.plan
            made = self._compensator.run(inputs)
            if self._confidence is not None:
                sure = dict(zip((colour for colour, _ in self._pairs), self._sure, strict=True))
                self._compensator.carry(inputs, lambda image: sure[image.colour], self._confidence)
            assert made.shown is not None and made.warped is not None, "only a fused plan lacks them"
            depth = made.inverse_depth if self._has_depth else None
            with gpu.timer.cpu_stage("download"):
                buffers = self._give_out.run(made.shown, made.warped, depth, self._confidence, kind, self._buffers)
            self._check_numbers(pictures)
            gpu.check_not_lost()
            share = found.holes / (self.size[0] * self.size[1])
            for note in self._notes(*pictures[0], shown, share):
                warnings.warn(note, stacklevel=self._level)
            with gpu.timer.cpu_stage("download"):
                arrays = self._give_out.arrays(buffers)
            whole_ms, times = gpu.timer.lap_ms, dict[str, float]()
            for stage, milliseconds in gpu.timer.collect():
                times[stage] = times.get(stage, 0.0) + milliseconds
            times["host"] = max(whole_ms - sum(times.values()), 0.0)  # their sum is the call
            return WarpedImage(arrays["colour"], arrays["coverage"], times, share, kind, arrays.get("depth_m"))

    def _pictures_of(self, given: list[Other], depth_scale: float | None, encoding: str | None) -> list[Picture]:
        """Return the picture and the others, each with its view. Errors: InputError."""
        found: list[Picture] = []
        for number, one in enumerate(given):
            name = f"others[{number - 1}]: " if number else ""
            try:
                colour, depth_m, view = one
            except (TypeError, ValueError) as error:
                raise InputError(f"{name}expected (colour, depth_m, view)") from error
            if not number and view.hidden is not None and np.ndim(colour) == 3:
                shape: Any = np.shape(colour)
                colour = np.ma.array(colour, mask=np.broadcast_to(~view.seen(shape[1::-1])[..., None], shape))
            picture = raw_picture(colour, depth_m, depth_scale, encoding)
            check_view(f"{name}view", view)
            if picture.size != self.rendered_size:
                (wide, high), (own_wide, own_high) = picture.size, self.rendered_size
                raise InputError(f"{name}colour is {wide}x{high} pixels: this Warper is for {own_wide}x{own_high}")
            found.append((picture, view))
        return found

    def _check_numbers(self, pictures: list[Picture]) -> None:
        """Check what the GPU has noted of them. Errors: InputError as CallerPicture.checked."""
        self._buffers.found.read()
        for number, (picture, _) in enumerate(pictures):
            if self._buffers.found.is_doubtful(number, self.rendered_size):
                picture.checked()

    def warp_textures(
        self,
        colour: moderngl.Texture,
        inverse_depth: moderngl.Texture,
        rendered: View,
        shown: View,
        *,
        layers: Mapping[str, Any] = MappingProxyType({}),
        eye: int = 0,
    ) -> WarpedTextures:
        """Return the view `shown` as textures, read from textures of the same context.

        Parameters
        ----------
        colour, inverse_depth : moderngl.Texture
            Of rendered_size, rows bottom to top: rgba16f linear light, whose alpha is 0 in holes,
            and r32f 1/m, below 0 where there is none. `gpu.gl.external_texture` makes one of an
            OpenGL id.
        rendered, shown, eye
            As warp.
        layers : mapping
            "panels" alone, as warp_image; what runs on arrays has no textures.

        Raises
        ------
        InputError
            For arguments that do not fit; without gpu=; and for warp "auto", a repair or a warp of
            several pictures, which take arrays.
        """
        _check_call(rendered, shown, eye)
        self._check_others(0)
        self._layers.check(layers, f"{self._named} runs on arrays where it")
        if self._own_gpu is None or self.repair.steps or self._compensator is None:
            raise InputError("textures are for a Warper with gpu=, the context they are of, a named warp and no repair")
        size = self.rendered_size
        for name, texture, kind in (("colour", colour, COLOUR), ("inverse_depth", inverse_depth, SCALAR)):
            fits = isinstance(texture, moderngl.Texture) and texture.size == size
            if not fits or (texture.components, texture.dtype) != kind:
                expected = f"{kind[0]} components of type {kind[1]}, of {size[0]}x{size[1]} pixels"
                raise InputError(f"{name} is {in_brief(texture)}: expected a moderngl.Texture of {expected}")
        with self._gpu() as gpu:
            self._count += 1
            image = EyeImage(rendered, colour, inverse_depth, self._layers.hold(layers), drawn_ns=self._count)
            made = self._compensator.run(self._inputs([image], shown, eye))
            gpu.check_not_lost()
            assert made.shown is not None, "only a fused plan lacks it"
            return WarpedTextures(made.shown.texture, made.inverse_depth, self)

    def close(self) -> None:
        """Free all textures and buffers; nothing after the first time, and in a forked process."""
        gpu = _shared if self._own_gpu is None else self._own_gpu
        if self._dropped.alive and gpu is not None and not gpu.closed:
            with self._context():
                self._dropped.detach()
                self._owner.close()

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

    def _notes(self, picture: CallerPicture, rendered: View, shown: View, hole_share: float) -> Iterator[str]:
        """Yield what to warn of: depth that is none, or hardly in metres, no picture; each once."""
        if _LARGEST not in self._warned:
            largest = list(picture.notes)
            if picture.light is None and self._buffers.found.has_largest(0):
                largest += about_largest([picture.depth])
            self._warned.update([_LARGEST] if largest else [])
            yield from largest
        moved_m = float(np.linalg.norm(shown.pose.position_m - rendered.pose.position_m))
        if _UNIT not in self._warned and moved_m:  # looked at once
            self._warned.add(_UNIT)
            yield from about_unit([picture.metres()], moved_m, "depth_scale={:g}")
        if self.plan.fills and _HOLES not in self._warned:  # where nothing fills holes, coverage tells of them
            empty = about_holes(hole_share, rendered, shown)
            self._warned.update([_HOLES] if empty else [])
            yield from empty

    @property
    def _named(self) -> str:
        return f"warp '{self.plan.choice}'" + "".join(f" with effect '{name}'" for name in self.plan.effects)

    def _check_others(self, others: int) -> None:
        """Check that the plan gets the other pictures that it reads, and no more."""
        named, most = self._named, self._needs.others.count + self._needs.others.recent
        if most and not others and self.plan.reads(OTHERS):
            raise InputError(f"{named} reads other pictures: give others=[(colour, depth_m, view), ..], at most {most}")
        if others > most:
            reads = f"reads at most {most}" if most else "reads none"
            raise InputError(f"others has {others} pictures, and {named} with fill '{self.plan.fill}' {reads}")

    def _inputs(self, images: list[EyeImage], shown: View, eye: int, age_ns: int = 0) -> PassInputs:
        count = 1 + self._needs.others.count
        others, recent = tuple(images[1:count]), tuple(images[count:])
        return PassInputs(images[0], shown, eye, others, recent, shown_ns=self._count + age_ns)


def _check_call(
    rendered: object, shown: object, eye: object, age_s: float = 0.0, result: object = None, others: object = ()
) -> None:
    if not isinstance(eye, Integral) or eye not in (0, 1):
        raise InputError(f"eye is {in_brief(eye)}: expected 0 (left) or 1 (right)")
    check_view("rendered", rendered)
    check_view("shown", shown)
    if isinstance(age_s, bool) or not isinstance(age_s, Real) or not abs(age_s) <= _MOST_AGE_S:
        raise InputError(f"age_s is {in_brief(age_s)}: expected seconds from drawing the picture to showing it")
    if not is_one_of(result, (SRGB8, SRGB, LINEAR)):
        raise InputError(f"result is {in_brief(result)}: expected srgb8, srgb, linear, or None for the picture's")
    if not isinstance(others, Sequence):
        expected = "a list of (colour, depth_m, view), or () for none"
        raise InputError(f"others is of type {type(others).__name__}: expected {expected}")


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
    layers: Mapping[str, Any] = MappingProxyType({}),
    age_s: float = 0.0,
    depth_scale: float | None = None,
    encoding: str | None = None,
    result: str | None = None,
    depth: bool = False,
    budget_ms: float | None = None,
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
        that draw this picture in budget_ms; `hmdwarp choose` names one by a benchmark of yours.
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
    layers : mapping
        Further layers by name, for effects that read them: velocity and panels; docs/rgbd.md says
        what each holds.
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
    own_size = raw_picture(colour, depth_m, depth_scale, encoding).size
    shown_size = own_size if size is None else checked_size(size)
    options: dict[str, Any] = {"warp": warp, "fill": fill, "effects": effects, "repair": repair, "depth": depth}
    with Warper(shown_size, rendered_size=own_size, gpu=gpu, budget_ms=budget_ms, **options) as warper:
        warper._level += 1
        said: dict[str, Any] = {"others": others, "layers": layers, "age_s": age_s, "depth_scale": depth_scale}
        return warper.warp(colour, depth_m, rendered, shown, **said, encoding=encoding, result=result)

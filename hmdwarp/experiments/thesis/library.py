"""Every figure, time and claim of the thesis as an experiment. A new one is one entry here.

Where a claim has no number ("little", "several times") the rule states one.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from ...registry import unknown_name
from .experiment import Cell, Experiment
from .run_kinds import (
    BACKWARD,
    FORWARD,
    LATENCIES_MS,
    ROTATE,
    SIDEWAYS,
    FactRun,
    Motion,
    PictureRun,
    RatingsRun,
    StreamRun,
    motions,
    size_text,
    usual,
)
from .values import (
    change,
    closed,
    growth_exponent,
    least_growth,
    least_step,
    not_known,
    only,
    ratio,
    relative_time,
    share_of,
)
from .verdicts import AtLeast, AtMost, Between

KINDS = (FORWARD, ROTATE, SIDEWAYS, BACKWARD)
# The thesis's sizes of the rendered picture: 1.41 and 2.03 times the pixels of the first.
SIZES = {size_text(guard): guard for guard in ((1.0, 1.0), (1.25, 1.125), (1.5, 1.35))}
# A share of the picture that nobody sees: one pixel in a thousand.
NEGLIGIBLE = 0.001
INTERPOLATE = "interpolate"
COMPOSITE, MODEL, UNLIT = "interpolate+composite", "interpolate+model", "interpolate+model:share=1,light=off"
REDUCED_TEXTURES = "interpolate+model:share=0.2,texture=0.25"
NO_REFLECTIONS, NO_NORMAL_MAP = "no-planar_reflections,no-glossy_reflections", "no-glossy_reflections"
PARTS, RATED_MS = ("run 1", "run 2"), (200.0, 400.0, 800.0)
RATED_BEFORE = "The ratings are those that the thesis published, analysed again; nobody was asked anew."


def _run(motion: Motion, latency_ms: float, **more: object) -> PictureRun:
    return PictureRun(motion=motion, latency_ms=latency_ms, **more)  # type: ignore[arg-type]


def _ms(latency_ms: float) -> str:
    return f"{latency_ms:g} ms"


def _cells(kinds: Sequence[str], latencies_ms: Sequence[float], *variants: dict[str, object]) -> Iterator[Cell]:
    """Yield a cell for each motion (a row) and latency (a column), with a run for each variant."""
    for motion, latency_ms in itertools.product(motions(*kinds), latencies_ms):
        yield Cell(str(motion), _ms(latency_ms), tuple(_run(motion, latency_ms, **one) for one in variants))


def _all_latencies(kinds: Sequence[str], **more: object) -> Iterator[Cell]:
    for motion in motions(*kinds):
        yield Cell(str(motion), "200, 400, 600 ms", tuple(_run(motion, latency, **more) for latency in LATENCIES_MS))


def _sizes(kinds: Sequence[str], latency_ms: float, size: str) -> Iterator[Cell]:
    for motion in motions(*kinds):
        yield Cell(str(motion), _ms(latency_ms), (_run(motion, latency_ms, guard=SIZES[size]),))


def _rated(part: str) -> Iterator[Cell]:
    for latency_ms in RATED_MS:
        yield Cell(part, _ms(latency_ms), (RatingsRun(part=part, latency_ms=latency_ms),))


TIMED = _run(usual(SIDEWAYS), 400.0, fill=INTERPOLATE, timed=True)
TIMED_DEPTH = _run(usual(SIDEWAYS), 400.0, warp="backward", timed=True)
TIMED_COMPOSITE = _run(usual(SIDEWAYS), 400.0, fill="composite", timed=True)
TIMED_REFLECTIONS = _run(usual(SIDEWAYS), 400.0, scene="gallery", timed=True)
LATE = StreamRun(warp="none")
WLAN = StreamRun(size=(1920, 1080), latency_ms=10.0, bandwidth_mbit=54.0)

EXPERIMENTS: tuple[Experiment, ...] = (
    Experiment(
        name="scene",
        source="section 4.1",
        claim="The test scene has about 75,000 triangles with baked light.",
        thesis="about 75,000",
        measured="triangles of scene room",
        value=only("value"),
        rule=Between(70_000, 80_000),
        digits=0,
        cells=(Cell("room", "triangles", (FactRun(fact="triangles"),)),),
    ),
    Experiment(
        name="ring",
        source="the latency ring",
        claim="In a ring of 60 frames at 60 Hz, place 30 is a latency of 500 ms.",
        thesis="place 30",
        measured="refreshes from drawing to showing at 500 ms and 60 Hz",
        value=only("value"),
        rule=Between(30, 30),
        digits=0,
        cells=(Cell("500 ms", "refreshes", (FactRun(fact="place_of_500_ms"),)),),
    ),
    Experiment(
        name="fig27",
        source="Figure 27",
        claim="Without a depth test the forward warp paints the background over what stands before it.",
        thesis="visible in the picture",
        measured="PSNR gained by the depth test, holes filled 3x3",
        value=change("psnr_db"),
        rule=AtLeast(0.1),
        unit="dB",
        cells=tuple(
            _cells(KINDS, (400.0,), {"warp": "forward_raster", "fill": INTERPOLATE}, {"fill": INTERPOLATE})
        ),
        pictures=(_run(usual(SIDEWAYS), 400.0, warp="forward_raster"), _run(usual(SIDEWAYS), 400.0)),
    ),
    Experiment(
        name="fig28-30",
        source="Figures 28 to 30",
        claim="Without a fill the holes grow with the latency when the head moves forward.",
        thesis="200, 400 and 600 ms: more and more holes",
        measured="least growth of the holes from one latency to the next",
        value=least_growth("hole_share"),
        rule=AtLeast(1.0),
        unit="times",
        cells=tuple(_all_latencies((FORWARD,))),
        pictures=tuple(_run(usual(FORWARD), latency) for latency in LATENCIES_MS),
    ),
    Experiment(
        name="fig31-33",
        source="Figures 31 to 33",
        claim="What the late frame holds is moved to its place, and the rest is black: rotation, sideways, backward.",
        thesis="visible in the pictures",
        measured="PSNR gained over the late picture, where the warp drew anything",
        value=only("gain_db"),
        rule=AtLeast(0.0),
        unit="dB",
        cells=tuple(_cells((ROTATE, SIDEWAYS, BACKWARD), (400.0,), {})),
        pictures=tuple(_run(usual(kind), 400.0) for kind in (ROTATE, SIDEWAYS, BACKWARD)),
    ),
    Experiment(
        name="holes-latency",
        source="the forward warp",
        claim="Holes grow with the latency.",
        thesis="for every motion",
        measured="least growth of the holes from one latency to the next",
        value=least_growth("hole_share"),
        rule=AtLeast(1.0),
        unit="times",
        cells=tuple(_all_latencies(KINDS)),
    ),
    Experiment(
        name="fig35-38",
        source="Figures 35 to 38",
        claim="The median of the 3x3 neighbours closes the cracks.",
        thesis="rotation; forward at 200, 400 and 600 ms: cracks closed, larger holes stay",
        measured="part of the cracks that 3x3 closes",
        value=closed("cracks_left_share", "crack_share"),
        rule=AtLeast(0.95),
        unit="%",
        digits=1,
        scale=100,
        cells=tuple(_cells((FORWARD, ROTATE), LATENCIES_MS, {"fill": INTERPOLATE})),
        pictures=(
            _run(usual(ROTATE), 400.0, fill=INTERPOLATE),
            *(_run(usual(FORWARD), latency, fill=INTERPOLATE) for latency in LATENCIES_MS),
        ),
        note="A crack is a hole whose surface the late frame had. The other holes are beyond its border or were hidden "
        "in it; see holes-closed for all of them.",
    ),
    Experiment(
        name="cracks",
        source="section 4.3.3",
        claim="Cracks are one pixel wide.",
        thesis="one pixel",
        measured="part of the cracks that 3x3 closes",
        value=closed("cracks_left_share", "crack_share"),
        rule=AtLeast(0.95),
        unit="%",
        digits=1,
        scale=100,
        cells=tuple(_cells(KINDS, LATENCIES_MS, {"fill": INTERPOLATE})),
    ),
    Experiment(
        name="holes-closed",
        source="section 4.3.3",
        claim="3x3 closes most holes inside the picture.",
        thesis="no number",
        measured="part of the holes within the rendered field of view that 3x3 closes",
        value=closed("inner_left_share", "inner_share"),
        rule=AtLeast(0.5),
        unit="%",
        digits=1,
        scale=100,
        cells=tuple(_cells(KINDS, LATENCIES_MS, {"fill": INTERPOLATE})),
    ),
    Experiment(
        name="kernel",
        source="section 4.3.3",
        claim="A larger kernel than 3x3 gains little.",
        thesis="little",
        measured="PSNR gained over 3x3",
        value=change("psnr_db"),
        rule=AtMost(0.5),
        unit="dB",
        cells=tuple(
            Cell(str(motion), f"{size}x{size} at {_ms(latency)}", (
                _run(motion, latency, fill=INTERPOLATE), _run(motion, latency, fill=f"{INTERPOLATE}:size={size}"),
            ))
            for motion in motions(*KINDS) for size in (5, 7) for latency in LATENCIES_MS
        ),
        pictures=tuple(_run(usual(FORWARD), 400.0, fill=fill) for fill in (
            INTERPOLATE, f"{INTERPOLATE}:size=5", f"{INTERPOLATE}:size=7",
        )),
    ),
    Experiment(
        name="fig39",
        source="Figure 39, Algorithm 2",
        claim="The backward warp with the client's own depth leaves no cracks.",
        thesis="none",
        measured="cracks, of all pixels",
        value=only("crack_share"),
        rule=AtMost(NEGLIGIBLE),
        unit="%",
        scale=100,
        cells=tuple(_cells(KINDS, LATENCIES_MS, {"warp": "backward"})),
        pictures=tuple(_run(usual(kind), 400.0, warp="backward") for kind in (ROTATE, SIDEWAYS)),
    ),
    Experiment(
        name="fig39-no-depth",
        source="Figure 39, section 4.3.3",
        claim="Without sent depth nothing can be tested, and the background is painted wrongly.",
        thesis="visible in the picture",
        measured="pixels that the test keeps from being painted wrongly, of all",
        value=change("inner_share"),
        rule=AtLeast(NEGLIGIBLE),
        unit="%",
        scale=100,
        cells=tuple(_cells(KINDS, (400.0,), {"warp": "backward:test=off"}, {"warp": "backward"})),
        pictures=tuple(_run(usual(kind), 400.0, warp="backward:test=off") for kind in (ROTATE, SIDEWAYS)),
    ),
    Experiment(
        name="fig40-43",
        source="Figures 40 to 43",
        claim="The rendered picture is so large that nothing of the border stays empty.",
        thesis="from 1600x900 at 200 ms, from 1920x1080 at 400 ms",
        measured="border holes, of all pixels",
        value=only("border_share"),
        rule=AtMost(NEGLIGIBLE),
        unit="%",
        scale=100,
        cells=tuple(
            Cell(str(motion), f"{size} at {_ms(latency)}", (_run(motion, latency, guard=guard),))
            for motion in motions(ROTATE, SIDEWAYS)
            for size, guard in SIZES.items()
            for latency in LATENCIES_MS
        ),
        pictures=tuple(
            _run(usual(kind), 400.0, guard=guard) for kind in (ROTATE, SIDEWAYS) for guard in SIZES.values()
        ),
    ),
    Experiment(
        name="size-200",
        source="section 4.4.3",
        claim="A picture of 1.41 times the pixels (1600x900) suffices at 200 ms.",
        thesis="suffices",
        measured="border holes, of all pixels",
        value=only("border_share"),
        rule=AtMost(NEGLIGIBLE),
        unit="%",
        scale=100,
        cells=tuple(_sizes((SIDEWAYS, ROTATE), 200.0, "1600x900")),
    ),
    Experiment(
        name="size-400",
        source="section 4.4.3",
        claim="A picture of 2.03 times the pixels (1920x1080) suffices at 400 ms.",
        thesis="suffices",
        measured="border holes, of all pixels",
        value=only("border_share"),
        rule=AtMost(NEGLIGIBLE),
        unit="%",
        scale=100,
        cells=tuple(_sizes((SIDEWAYS, ROTATE), 400.0, "1920x1080")),
    ),
    Experiment(
        name="fig44-45",
        source="Figures 44 and 45",
        claim="A model of 20 % of the triangles fills every hole.",
        thesis="every hole",
        measured="what stays empty, of all pixels",
        value=only("empty_share"),
        rule=AtMost(NEGLIGIBLE),
        unit="%",
        scale=100,
        cells=tuple(_cells((ROTATE, SIDEWAYS), LATENCIES_MS, {"fill": MODEL})),
        pictures=tuple(_run(usual(kind), 400.0, fill=MODEL) for kind in (ROTATE, SIDEWAYS)),
    ),
    Experiment(
        name="fig44-45-textures",
        source="Figures 44 and 45",
        claim="The model's textures may be reduced as well.",
        thesis="visible in the pictures",
        measured="change of the PSNR by textures of a quarter of the size",
        value=change("psnr_db"),
        rule=AtLeast(-0.5),
        unit="dB",
        cells=tuple(_cells((ROTATE, SIDEWAYS), LATENCIES_MS, {"fill": MODEL}, {"fill": REDUCED_TEXTURES})),
        pictures=tuple(_run(usual(kind), 400.0, fill=REDUCED_TEXTURES) for kind in (ROTATE, SIDEWAYS)),
    ),
    Experiment(
        name="fig47-49",
        source="Figures 47 to 49, Algorithm 3",
        claim="The composite that estimates the light reduces the discontinuities at the edges of holes.",
        thesis="400 ms: fewer than with the unlit model",
        measured="false step at the seams, over that of the unlit model",
        value=ratio("seam"),
        rule=AtMost(0.95),
        unit="times",
        cells=tuple(_cells(KINDS, (400.0,), {"fill": UNLIT}, {"fill": COMPOSITE})),
        pictures=tuple(_run(usual(SIDEWAYS), 400.0, fill=fill) for fill in (UNLIT, COMPOSITE, "interpolate+relight")),
    ),
    Experiment(
        name="composite-flickers",
        source="section 5.2",
        claim="The composite flickers.",
        thesis="what the testers of run 2 complained of",
        measured="flicker, over that of the unlit model",
        value=ratio("flicker"),
        rule=AtLeast(1.05),
        unit="times",
        cells=tuple(
            _cells(KINDS, (400.0,), {"fill": UNLIT, "flickers": True}, {"fill": COMPOSITE, "flickers": True})
        ),
    ),
    Experiment(
        name="composite-black",
        source="section 4.6",
        claim="Where the composite finds no light, holes stay black.",
        thesis="not all holes are filled",
        measured="what stays empty, of all pixels",
        value=only("empty_share"),
        rule=AtLeast(NEGLIGIBLE),
        unit="%",
        scale=100,
        cells=tuple(_cells(KINDS, LATENCIES_MS, {"fill": COMPOSITE})),
    ),
    Experiment(
        name="fig50-54",
        source="Figures 50 and 52 to 54",
        claim="Reflections that are warped by their own depth are right; not warped they stay where they were.",
        thesis="visible in the pictures",
        measured="PSNR gained by warping them",
        value=change("psnr_db"),
        rule=AtLeast(0.1),
        unit="dB",
        cells=tuple(
            _cells(
                (SIDEWAYS, FORWARD, ROTATE), (400.0,),
                {"scene": "gallery", "effects": NO_REFLECTIONS, "fill": INTERPOLATE},
                {"scene": "gallery", "effects": NO_NORMAL_MAP, "fill": INTERPOLATE},
            )
        ),
        pictures=tuple(
            _run(usual(SIDEWAYS), 400.0, scene="gallery", effects=effects, fill=INTERPOLATE)
            for effects in (NO_REFLECTIONS, NO_NORMAL_MAP)
        ),
    ),
    Experiment(
        name="fig55",
        source="Figure 55",
        claim="A normal map makes warped reflections glossy.",
        thesis="visible in the picture",
        measured="PSNR gained by warping glossy reflections too",
        value=change("psnr_db"),
        rule=AtLeast(0.01),
        unit="dB",
        cells=tuple(
            _cells(
                (SIDEWAYS, FORWARD, ROTATE), (400.0,),
                {"scene": "gallery", "effects": NO_NORMAL_MAP, "fill": INTERPOLATE},
                {"scene": "gallery", "fill": INTERPOLATE},
            )
        ),
        pictures=(_run(usual(SIDEWAYS), 400.0, scene="gallery", fill=INTERPOLATE),),
    ),
    Experiment(
        name="reflections-cost",
        source="section 4.7",
        claim="Reflections cost less than a warp.",
        thesis="1 ms against 2 ms",
        measured="time of the reflections over that of the warp",
        value=ratio("effects_ms", "warp_ms"),
        rule=AtMost(1.0),
        unit="times",
        cells=(Cell("reflections", "over the warp", (TIMED_REFLECTIONS,)),),
    ),
    Experiment(
        name="times",
        source="its times",
        claim="Copy, warp, client depth, interpolation, composite and reflections take 1, 2, 3, 3, 2 and 1 ms.",
        thesis="1 : 2 : 3 : 3 : 2 : 1",
        measured="time over the warp's, over the same ratio of the thesis",
        value=not_known,
        rule=Between(0.5, 2.0),
        unit="times",
        cells=(
            Cell("copy", "to the warp", ()),
            Cell("client depth", "to the warp", (TIMED, TIMED_DEPTH), value=relative_time("client_depth", "warp", 1.5)),
            Cell("interpolation", "to the warp", (TIMED, TIMED), value=relative_time("fill", "warp", 1.5)),
            Cell("composite", "to the warp", (TIMED, TIMED_COMPOSITE), value=relative_time("fill", "warp", 1.0)),
            Cell("reflections", "to the warp", (TIMED, TIMED_REFLECTIONS), value=relative_time("effects", "warp", 0.5)),
        ),
        note="Ratios, as the machine is another. The copy into the ring has no counterpart: a frame stays where it was "
        "drawn, in textures from a pool. On llvmpipe the passes run on the CPU, and drawing triangles weighs more.",
    ),
    Experiment(
        name="linear",
        source="the forward warp",
        claim="The cost of the warp is linear in the pixels.",
        thesis="O(n)",
        measured="exponent of the pixels in the time of the warp",
        value=growth_exponent("warp_ms"),
        rule=Between(0.8, 1.2),
        cells=tuple(
            Cell(f"{small:g} to {large:g} of each side", "exponent", tuple(
                _run(usual(SIDEWAYS), 400.0, scale=scale, fill=INTERPOLATE, timed=True) for scale in (small, large)
            ))
            for small, large in ((0.25, 0.5), (0.5, 1.0))
        ),
    ),
    Experiment(
        name="depth-bandwidth",
        source="section 3.4",
        claim="Depth adds little to the bandwidth of an imposter.",
        thesis="a small part",
        measured="Mbit/s with depth over those without",
        value=ratio("mbit_s"),
        rule=AtMost(1.25),
        unit="times",
        cells=(Cell("h264", "colour and depth", (LATE, StreamRun(warp="forward"))),),
    ),
    Experiment(
        name="environment-bandwidth",
        source="section 3.3",
        claim="An environment map costs several times the bandwidth of an imposter.",
        thesis="several times",
        measured="Mbit/s of the map over those of the picture",
        value=ratio("mbit_s"),
        rule=AtLeast(2.0),
        unit="times",
        digits=1,
        cells=(Cell("h264", "map over picture", (LATE, StreamRun(warp="environment"))),),
    ),
    Experiment(
        name="fig10",
        source="Figure 10, section 2.3",
        claim="A stream of 1920x1080 pictures over a WLAN answers after 50 to 150 ms.",
        thesis="50 to 150 ms",
        measured="response time: all that this machine and the link add",
        value=only("response_ms"),
        rule=Between(50.0, 150.0),
        unit="ms",
        digits=0,
        cells=(Cell("h264", "1920x1080, 60 Hz", (WLAN,)),),
        pictures=(WLAN,),
        note="The link delays by 10 ms and carries 54 Mbit/s for both eyes; rendering, encoding and decoding take what "
        "they take here. It is judged only where a GPU renders.",
    ),
    Experiment(
        name="fig10-load",
        source="Figure 10, section 2.3",
        claim="The stream takes 40 to 60 % of the WLAN.",
        thesis="40 to 60 %",
        measured="Mbit/s of one eye's picture over 28",
        value=share_of(28.0),
        rule=Between(0.4, 0.6),
        unit="%",
        digits=0,
        scale=100,
        cells=(Cell("h264", "1920x1080, 60 Hz", (StreamRun(size=(1920, 1080)),)),),
        note="The thesis does not say what its WLAN carried: of 28 Mbit/s its 14 are the middle of its range.",
    ),
    Experiment(
        name="fig10-bandwidth",
        source="Figure 10, section 2.3",
        claim="A stream of 1920x1080 pictures takes about 14 Mbit/s.",
        thesis="14 Mbit/s",
        measured="Mbit/s of one eye's picture",
        value=only("full_size_mbit_s"),
        rule=Between(7.0, 28.0),
        unit="Mbit/s",
        digits=1,
        cells=(Cell("h264", "1920x1080, 60 Hz", (StreamRun(size=(1920, 1080)),)),),
    ),
    Experiment(
        name="ratings-latency",
        source="Tables 2 and 3",
        claim="The later the picture, the worse its mean grade, warped or not.",
        thesis="200, 400 and 800 ms",
        measured="least change of the mean grade from one latency to the next; positive: worse",
        value=not_known,
        rule=AtLeast(0.0),
        unit="grades",
        cells=tuple(
            Cell(part, what, tuple(RatingsRun(part=part, latency_ms=ms) for ms in RATED_MS), value=least_step(what))
            for part in PARTS
            for what in ("late", "warped")
        ),
        note=RATED_BEFORE,
    ),
    *(
        Experiment(
            name=f"ratings-{part.replace(' ', '')}",
            source=table,
            claim=f"In {part} ({what}) the warped picture is rated better than the late one.",
            thesis=says,
            measured="mean difference of the pairs; positive: warped is better",
            value=only("mean"),
            rule=AtLeast(0.0),
            unit="grades",
            cells=tuple(_rated(part)),
            note=RATED_BEFORE,
        )
        for part, table, what, says in (
            ("run 1", "Table 2", "3x3 interpolation", "+0.4, +1.35, +1.4 grades"),
            ("run 2", "Table 3", "interpolation and composite", "-0.5, +0.475, +1.15 grades"),
        )
    ),
    Experiment(
        name="ratings-tests",
        source="section 5.2",
        claim="The differences of the ratings are more than chance.",
        thesis="not tested",
        measured="exact two-sided p after Holm within the run",
        value=only("p"),
        rule=AtMost(0.05),
        digits=4,
        cells=tuple(cell for part in PARTS for cell in _rated(part)),
    ),
    Experiment(
        name="ratings-figures",
        source="section 5.2",
        claim="The published differences follow from the published ratings.",
        thesis="six differences",
        measured="distance of the published difference from that of the ratings",
        value=only("off"),
        rule=AtMost(0.025 + 1e-9),
        unit="grades",
        digits=3,
        cells=tuple(cell for part in PARTS for cell in _rated(part)),
    ),
)  # fmt: skip


def experiments_named(names: Sequence[str]) -> tuple[Experiment, ...]:
    """Return the experiments of these names in the order of the page; all for no name.

    A beginning stands for all that begin so: "ratings", or "fig28" for "fig28-30".
    Errors: UnknownNameError.
    """
    known = [one.name for one in EXPERIMENTS]
    chosen = set[str]()
    for name in names:
        found = [name] if name in known else [one for one in known if name and one.startswith(name)]
        if not found:
            raise unknown_name("experiment of the thesis", name, known)
        chosen.update(found)
    return tuple(one for one in EXPERIMENTS if not names or one.name in chosen)

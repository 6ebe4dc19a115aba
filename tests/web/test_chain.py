"""The warps in a browser's WebGL 2 beside those of hmdwarp, on the same pictures and views."""

from __future__ import annotations

import base64
import json
import struct

import needs
import numpy as np
import pytest

from hmdwarp import Fov, Panel, Pose, View, warp_image
from hmdwarp.base import srgb8_from_linear
from hmdwarp.frames.layers import Outbox
from hmdwarp.frames.layers.panels import things_of, with_showing
from hmdwarp.gpu import download
from hmdwarp.pipeline.feed_coding import FeedDecoder, FeedEncoder
from hmdwarp.scenes import load_scene
from hmdwarp.sources.feed.message import AV1, DEPTH_VIDEO8, H264, VP9, Ask, FrameMessage, Wish, encode
from hmdwarp.sources.server import Server
from hmdwarp.web import STEPS

from .browser import Browser

pytestmark = needs.programs("chromium")

# Both write half floats, of light up to 1: each is rounded by up to 2^-12; and take in light of
# bytes that the one has rounded so already, 2^-12 more. Samplers weigh texels by at least 8 bits of
# a pixel, so beside a step of 1 they may differ by 2^-9 each.
MOST_OFF = 2.0**-8 + 3 * 2.0**-12
# Where a comparison stands on the brink, roundings decide: pixels of a border's column at most.
MOST_PARTED = 0.01
SIZE = (96, 80)
EYE = Fov.symmetric(*np.radians((90, 78)))
STANDING = Pose((0.1, 1.6, 0.2))
FAR = 1e6


def turned(x_deg: float = 0, y_deg: float = 0, position: tuple = (0.0, 0.0, 0.0)) -> Pose:
    x, y = np.deg2rad([x_deg, y_deg]) / 2
    about_y = Pose((0, 0, 0), (0, np.sin(y), 0, np.cos(y)))
    return Pose(position) @ about_y @ Pose((0, 0, 0), (np.sin(x), 0, 0, np.cos(x)))


# Of the eye that is shown, in the one that was rendered: its pose, field of view, size.
CASES = {
    "unmoved": (Pose(), EYE, SIZE),
    "turned": (turned(-3, 8), EYE, SIZE),
    "moved": (turned(0, 0, (0.12, -0.05, -0.2)), EYE, SIZE),
    "both, of another size": (turned(4, -6, (-0.15, 0.02, 0.1)), EYE, (75, 61)),
    "canted, asymmetric": (turned(0, 10, (0.064, 0, 0)), Fov(-0.9, 0.7, -0.8, 0.6), SIZE),
    "turned away": (turned(0, 120), EYE, SIZE),
}


WARPS = [("rotation", "rotation"), ("iterative", f"iterative:frames=1,seed=rotation,steps={STEPS}")]


@pytest.fixture(scope="module")
def rendered(gpu):
    """(h, w, 4) sRGB and coverage, (h, w) in 1/m of the room, with sky and holes, from the top."""
    server = Server(gpu, load_scene("room"))
    frame = server.draw_frame((View(STANDING, EYE),), 0, SIZE)
    colour, depth = (download(texture) for texture in (frame.eyes[0].colour, frame.eyes[0].inverse_depth))
    server.close()
    depth = depth.copy()
    depth[:20, 30:50], depth[50:60, 10:25] = 0, -1
    coverage = np.where(depth < 0, 0, 255).astype(np.uint8)
    return np.dstack([srgb8_from_linear(colour[..., :3]), coverage]) * (coverage > 0)[..., None], depth


def _pose(pose: Pose) -> dict:
    return {"position": pose.position_m.tolist(), "orientation": pose.orientation_xyzw.tolist()}


def _view(view: View) -> dict:
    fov = view.fov
    angles = [fov.left, fov.right, fov.down, fov.up]
    return {"pose": _pose(view.pose), "head_from_eye": _pose(view.head_from_eye), "fov": angles}


def _base64(array: np.ndarray) -> str:
    return json.dumps(base64.b64encode(np.ascontiguousarray(array).tobytes()).decode())


# What a warp finds, its depth, and what is shown once holes are filled.
READ = """
(shown, name, panels) => {
  const light = chain.read(0, shown, name, panels), depth = new Float32Array(light.length), { gl } = chain;
  gl.readBuffer(gl.COLOR_ATTACHMENT1);
  gl.readPixels(0, 0, ...shown.size, gl.RGBA, gl.FLOAT, depth);
  gl.readBuffer(gl.COLOR_ATTACHMENT0);
  const filled = chain.scratch(shown.size);
  chain.show(0, shown, name, filled.target, [0, 0], "pyramid", panels);
  const bytes = chain.pixels(filled.target, shown.size);
  chain.dropped(filled);
  return [light, depth, bytes].map(packed);
}
"""


def in_browser(browser: Browser, colour, depth, rendered: View, shown: View, size, chain: str, panels: str = "[]"):
    """Return light and coverage (h, w, 4) before the page's fill, their depth, sRGB after it."""
    given = {"size": [colour.shape[1], colour.shape[0]], "view": _view(rendered)}
    numbers = f"new Float32Array(bytes({_base64(depth)}).buffer)"
    picture = f"colour: bytes({_base64(colour)}), depth: {{numbers: {numbers}}}"
    browser.does(f"chain.takeIn(0, {{...{json.dumps(given)}, {picture}}})")
    view = json.dumps({**_view(shown), "size": list(size)})
    found = [base64.b64decode(text) for text in browser.does(f"({READ})({view}, {json.dumps(chain)}, {panels})")]
    light, depths, shown_bytes = (
        np.frombuffer(one, kind).reshape(*size[::-1], 4) for one, kind in zip(found, ("f4", "f4", "u1"), strict=True)
    )
    return light[::-1], depths[::-1, :, 0], shown_bytes[..., :3]


@pytest.mark.parametrize("where", ["near the origin", "a thousand kilometres off"])
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(("chain", "warp"), WARPS)
def test_the_same_picture_as_here(browser, rendered, chain, warp, case, where):
    colour, depth = rendered
    moved, fov, size = CASES[case]
    base = Pose((FAR, 0, -FAR)) @ STANDING if where != "near the origin" else STANDING
    from_, to = View(base, EYE), View(base @ moved, fov)
    with np.errstate(divide="ignore"):
        metres = np.where(depth < 0, np.nan, 1 / depth)
    here = warp_image(colour, metres, from_, to, warp, "none", size, result="linear")
    there, _, _ = in_browser(browser, colour, depth, from_, to, size, chain)
    seen, there_seen = here.coverage > 0, there[..., 3] > 0
    assert np.mean(seen != there_seen) <= MOST_PARTED
    assert np.abs(here.colour - there[..., :3])[seen & there_seen].max(initial=0) <= MOST_OFF
    assert seen.mean() > 0.5 or case == "turned away"


@pytest.mark.parametrize("case", [name for name in CASES if name != "turned away"])
@pytest.mark.parametrize(("chain", "warp"), WARPS)
def test_the_depth_and_the_shown_image_are_those_of_here(browser, chain, warp, case):
    """A slanted wall of one colour, then with poles before it: holes show the wall, as here."""
    moved, fov, size = CASES[case]
    from_, to = View(STANDING, EYE), View(STANDING @ moved, fov)
    depth = np.broadcast_to(np.linspace(0.2, 0.3, SIZE[0], dtype=np.float32), SIZE[::-1]).copy()
    colour = np.full((*SIZE[::-1], 4), (40, 120, 200, 255), np.uint8)
    for has_poles in (False, True):
        if has_poles:
            depth[:, 5::12], colour[:, 5::12, :3] = 1.2, (230, 60, 20)
        here, bare = (
            warp_image(colour, 1 / depth, from_, to, warp, fill, size, result="srgb8", depth=True)
            for fill in ("pyramid", "none")
        )
        light, there_depth, there = in_browser(browser, colour, depth, from_, to, size, chain)
        seen = (light[..., 3] > 0) & (bare.coverage > 0)
        off = np.abs(here.colour.astype(int) - there).max(axis=-1)
        assert off[seen].max() <= 2 and seen.mean() > 0.4  # half floats, and a byte's rounding
        # Beside poles the page's depth is that of their fringes.
        assert has_poles or np.allclose(there_depth[seen], 1 / bare.depth_m[seen], rtol=1e-4, atol=0)
        # A pole counts by a fiftieth in holes, at each level; by the half this would be 30 to 47.
        assert np.percentile(off[~seen], 90) <= 10 if (~seen).any() else case in ("unmoved", "moved")


def brought(panels: list[Panel], change=lambda content: content) -> str:
    """Return a script that makes panels of what a frame brings; it finds what is wrong, or null."""
    content = with_showing(Outbox(things_of(panels)).update(range(99), 1 << 20, 0), 0, [0] * len(panels)).content
    came = np.frombuffer(change(content.tobytes()), np.uint8)
    frame = f"{{ began: 1, panels: {{ bytes: bytes({_base64(came)}), length: {len(came)} }} }}"
    return (
        f"(async () => {{ globalThis.panels = new Panels(chain); const frame = {frame}; "
        "try { await panels.take(frame); } catch (error) { return error.message; } "
        "panels.show(frame); return null; })()"
    )


PAGE = np.random.default_rng(3).integers(0, 256, (64, 128, 4), dtype=np.uint8)
LABEL = np.random.default_rng(4).integers(0, 256, (8, 16, 3), dtype=np.uint8)
# Relative to the eye that was rendered; magnified, minified and aslant; partly in what was seen.
PAGE_AT, LABEL_AT = turned(-5, 25, (-0.3, 0.1, -1.6)), Pose((0.15, -0.2, -1.0))
# The samplers weigh texels by at least 8 bits on each axis, beside steps of 1; and half floats
# round texels and what is between them.
MOST_OFF_PANEL = 2 * 2.0**-8 + 4 * 2.0**-12


@pytest.mark.parametrize("occluded", [False, True])
@pytest.mark.parametrize("case", CASES)
def test_panels_are_laid_as_here(browser, rendered, case, occluded):
    """One in the world and one on the head, over each other and over what is warped."""
    colour, depth = rendered
    moved, fov, size = CASES[case]
    base = Pose((FAR, 0, -FAR)) @ STANDING
    head_from_eye = turned(0, 6, (0.032, 0, 0))
    from_, to = View(base, EYE), View(base @ moved, fov, head_from_eye)
    panels = [
        Panel(PAGE, base @ PAGE_AT, (1.5, 0.75), occluded=occluded),
        Panel(LABEL, head_from_eye @ LABEL_AT, (0.6, 0.3), head_locked=True, occluded=occluded),
    ]
    with np.errstate(divide="ignore"):
        metres = np.where(depth < 0, np.nan, 1 / depth)
    warp = f"iterative:frames=1,seed=rotation,steps={STEPS}"
    effects = "panels,occluded_panels" if occluded else "panels"
    here, bare = (
        warp_image(colour, metres, from_, to, warp, "none", size, result="linear", **laid)
        for laid in ({"layers": {"panels": panels}, "effects": effects}, {})
    )
    assert browser.does(brought(panels)) is None
    there, _, _ = in_browser(browser, colour, depth, from_, to, size, "iterative", "panels.laid")
    seen, laid = here.coverage > 0, np.abs(here.colour - bare.colour).max(axis=-1) > 0.01
    off = np.abs(here.colour - there[..., :3]).max(axis=-1)
    assert np.mean(seen & ((off > MOST_OFF + MOST_OFF_PANEL) | (there[..., 3] < 1 - 2.0**-9))) <= MOST_PARTED
    assert laid.mean() > 0.02


def _put(at: int, how: str, *numbers):
    """Return what changes a row of numbers in what a frame brings of panels."""
    return lambda content: content[:at] + struct.pack(how, *numbers) + content[at + struct.calcsize(how) :]


THING = 8 + 2 + 2 + 14  # after the instant, one panel's picture, the first fragment's head
PICTURE = THING + 76 + 14


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda content: content[:5], "Offset is outside"),
        (lambda content: content[:-7], "does not fit"),
        (_put(8, "<H", 9), "does not fit"),
        (_put(10, "<H", 1), "show other pictures"),
        (_put(THING, "<d", np.nan), "a panel at NaN"),
        (_put(THING + 24, "<d", 3), "a panel at"),
        (_put(THING + 56, "<d", -1), "a panel at"),
        (_put(THING + 56, "<d", np.inf), "a panel at"),
        (_put(THING - 2, "<H", 75), "75 bytes of places"),
        (_put(PICTURE, "<I", 0), "decoded"),
        (_put(PICTURE + 16, ">I", 8193), "a picture of 8193x8: 8192 a side at most"),
    ],
)
def test_what_is_no_panel_is_refused_in_a_line(browser, change, message):
    panel = Panel(LABEL, Pose(), (1, 1))
    assert message in browser.does(brought([panel], change))
    assert "of places" in browser.does(brought([panel] * 16)), "more than fit"


@pytest.mark.parametrize("video", [H264, VP9, AV1])
def test_a_picture_of_videos_is_what_python_decodes(browser, rendered, video):
    """Depth by its very codes; colour within what two decoders' chroma and rounding may differ by.

    Python places chroma as the stream says, in the middle of four pixels; browsers differ there by
    up to half a pixel of chroma, so the picture's colours are smooth here.
    """
    _, depth = rendered
    across = np.linspace(0, 1, SIZE[0], dtype=np.float16)
    light = np.broadcast_to(np.stack([across, 0.5 * across, 1 - across, across * 0 + 1], -1), (*SIZE[::-1], 4))
    view = View(STANDING, EYE)
    ask = Ask(1, 0, 0, 0, 0, SIZE, STANDING, (view,), wish=Wish(video, DEPTH_VIDEO8, 10))
    coder, decoder = FeedEncoder(ask), FeedDecoder()
    browser.does("globalThis.video = null")
    for number in (1, 2):
        frame = FrameMessage(number, 0, 0, 0, 0, 0, (view,), (srgb8_from_linear(light),), (depth,))
        coded = coder.encode(frame)
        here = decoder.decode(coded)
        whole = json.dumps(base64.b64encode(encode(coded)).decode())
        found = browser.does(
            f"(async () => {{ const frame = decode(bytes({whole}).buffer); video ??= new VideoEye(frame); "
            "const { colour, depth } = await video.decode(frame, frame.eyes[0]); "
            "const picture = await createImageBitmap(colour); const flat = new OffscreenCanvas(...frame.size); "
            "flat.getContext('2d').drawImage(picture, 0, 0); colour.close(); "
            "return [packed(flat.getContext('2d').getImageData(0, 0, ...frame.size).data), packed(depth.codes), "
            "packed(depth.kinds), depth.step, depth.bend]; })()"
        )
        colour, codes, kinds = (np.frombuffer(base64.b64decode(text), np.uint8) for text in found[:3])
        step, bend = found[3:]
        codes = np.where(codes == 0, 0.25, codes)
        values = step * (bend * np.expm1(codes / bend) if bend else codes)
        values = np.where(kinds == 0, values, np.where(kinds == 1, 0, -1)).reshape(SIZE[::-1])
        np.testing.assert_allclose(values, here.inverse_depths[0], rtol=2e-7)
        drawn = here.colours[0][..., 3] > 0
        off = np.abs(colour.reshape(*SIZE[::-1], 4)[..., :3].astype(int) - srgb8_from_linear(here.light(0)[..., :3]))
        assert np.percentile(off[drawn], 99) <= 4


HEARD = """
async (messages) => {
  const { Feed } = await import("./feed.js"), known = [];
  const feed = new (class extends Feed { open() {} })("", { frame() {}, told() {} });
  for (const message of messages) {
    feed.known = 3; // of what people did
    feed.take(bytes(message).buffer);
    known.push(feed.known);
  }
  return [known, feed.fates.map(({ number, arrived }) => [number, arrived])];
}
"""


def test_frames_that_never_came_and_a_server_started_anew_are_noticed(browser):
    picture = (View(STANDING, EYE),), (np.zeros((2, 2, 4), np.float16),), (np.zeros((2, 2), np.float32),)
    more = {"layers": ({"panels": (np.zeros((1, 10), np.uint8),)},), "takes_session": True}
    came = (FrameMessage(k, 0, 0, 0, 0, 0, *picture, began=began, **more) for k, began in ((1, 7), (4, 7), (5, 8)))
    known, fates = browser.does(f"({HEARD})({json.dumps([base64.b64encode(encode(one)).decode() for one in came])})")
    assert known == [0, 3, 0] and fates == [[1, True], [2, False], [3, False], [4, True], [5, True]]


DEVICES = {
    "all in hardware": (["av1", "hevc", "vp9", "h264"], ["av1", "hevc", "vp9", "h264"], "auto", "av1 hevc vp9 h264"),
    "some in hardware": (["av1", "vp9", "h264"], ["vp9"], "auto", "vp9 h264"),
    "in software alone": (["av1", "vp9", "h264"], [], "auto", "h264"),
    "one that is chosen": (["av1", "vp9", "h264"], [], "av1", "av1"),
    "one that it lacks": (["vp9", "h264"], ["vp9"], "av1", "vp9 h264"),
    "no depth": (["av1", "vp9"], ["av1"], "auto", ""),
}


@pytest.mark.parametrize("device", DEVICES)
def test_the_best_video_of_a_device_is_chosen(browser, device):
    """By what its decoder says it takes, and takes in hardware; depth is H.264, always."""
    decodes, quickly, wanted, chosen = DEVICES[device]
    found = browser.does(
        f"(async () => {{ const {{ VIDEOS, decodable }} = await import('./coded.js'), all = {json.dumps(decodes)}, "
        f"quick = {json.dumps(quickly)}; const takes = async ({{ codec, hardwareAcceleration: how }}) => "
        "(how ? quick : all).some((name) => VIDEOS[name].type === codec); "
        f"return decodable(['av1', 'hevc', 'vp9', 'h264'], '{wanted}', takes); }})()"
    )
    assert " ".join(found) == chosen


def test_depth_that_is_missing_is_told_by_its_place(browser):
    assert browser.does(
        "(async () => (await new VideoEye({ size: [64, 64], colour: 3 }).decode({ place: 3, begins: false }, {})) "
        "=== null)()"
    )


MASKED = """
(mask) => {
  const size = [48, 40], pose = { position: [0, 0, 0], orientation: [0, 0, 0, 1] };
  const shown = { pose, fov: [-0.7, 0.7, -0.6, 0.6], size };
  const colour = new Uint8Array(4 * 48 * 40).fill(200).map((value, k) => (k % 4 === 3 ? 255 : value));
  chain.takeIn(0, { size, colour, depth: { numbers: new Float32Array(48 * 40).fill(0.5) }, view: shown });
  const seen = mask && chain.mask(new Float32Array(mask), new Uint32Array([0, 1, 2])), { target } = chain.scratch(size);
  return ["iterative", "rotation", "mesh:grid=64"].map((name) => {
    chain.draw(target, shown.size, 0);
    chain.gl.clear(chain.gl.COLOR_BUFFER_BIT);
    chain.show(0, { ...shown, mask: seen }, name, target);
    return packed(chain.pixels(target, shown.size));
  });
}
"""


def test_what_a_lens_hides_is_not_drawn(browser):
    """Half of the tangents, a triangle: its pixels are those of the whole picture, no others are
    drawn.
    """
    x, y = np.tan([0.7, 0.6]).tolist()
    found = [browser.does(f"({MASKED})({json.dumps(mask)})") for mask in (None, [-x, -y, x, -y, -x, y])]
    pictures = ([np.frombuffer(base64.b64decode(text), np.uint8).reshape(40, 48, 4) for text in one] for one in found)
    inside = np.add.outer((np.arange(40) + 0.5) / 20, -(np.arange(48) + 0.5) / 24) > 0
    for full, part in zip(*pictures, strict=True):
        assert (full[..., :3] > 150).all()
        np.testing.assert_array_equal(part[..., :3], np.where(inside[..., None], full[..., :3], 0))

"""Colours and depths on their way to the screen.

SRGB by the shader and by the GPU, places, scaling, text, and what must not disturb.
"""

from __future__ import annotations

import moderngl
import numpy as np
import pytest
from scipy.ndimage import map_coordinates
from scipy.spatial.transform import Rotation

from hmdwarp.base import linear_from_srgb, srgb8_from_linear, srgb_from_linear
from hmdwarp.display import FRAMEBUFFER_SRGB, Presenter, text_ink
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import SCALAR, Canvas, allocate, download, upload

SRGB8_ALPHA8 = 0x8C43
WAYS = pytest.mark.parametrize("hardware", [False, True], ids=["shader", "hardware"])


@pytest.fixture
def presenter(gpu):
    made = Presenter(gpu)
    yield made
    made.close()


class Screen:
    """A framebuffer as a window (plain) or a runtime (sRGB) gives one, filled with a colour that
    nothing here draws.
    """

    UNTOUCHED = (9, 99, 199, 77)

    def __init__(self, gl, size, srgb: bool) -> None:
        self.texture = gl.texture(size, 4, internal_format=SRGB8_ALPHA8) if srgb else gl.texture(size, 4)
        self.texture.write(bytes(self.UNTOUCHED) * (size[0] * size[1]))
        self.framebuffer = gl.framebuffer([self.texture])

    def bytes(self) -> np.ndarray:
        """(h, w, 4), bottom row first, as they are stored."""
        w, h = self.texture.size
        return np.frombuffer(self.framebuffer.read(components=4), np.uint8).reshape(h, w, 4)


def canvas_of(gl, image: np.ndarray) -> Canvas:
    """image: (h, w, 4) linear, bottom row first."""
    canvas = Canvas(gl, image.shape[1::-1])
    canvas.texture.write(np.ascontiguousarray(image, np.float16).tobytes(), alignment=1)
    return canvas


def shown(gpu, presenter, image, size, viewport=None, hardware=False, **more) -> np.ndarray:
    screen = Screen(gpu.gl, size, hardware)
    canvas = canvas_of(gpu.gl, image) if image is not None else None
    presenter.show(canvas, screen.framebuffer, viewport or (0, 0, *size), hardware_srgb=hardware, **more)
    return screen.bytes()


def rounding(gpu) -> float:
    """What storing eight bits may be off by, in levels: half on llvmpipe; GPUs keep to Direct3D's
    limit for float to UNORM, 0.6.
    """
    return 0.5 if gpu.is_software else 0.6


def random_picture(seed: int, w: int, h: int) -> np.ndarray:
    image = np.random.default_rng(seed).random((h, w, 4)).astype(np.float16)
    image[..., 3] = 1
    return image


@WAYS
def test_all_256_levels_arrive_as_they_are(gpu, presenter, hardware):
    """float16 moves a level by less than 0.07 of one.

    That is 2^-11 of the light, times the curve's slope: 255 * 2^-11 / 2.4 at most, and 10 * 2^-11
    in the straight part. Both encoders stay within 0.4 of it (the hardware's own limit, with the
    rounding, is 0.6).
    """
    levels = np.arange(256, dtype=np.uint8).reshape(16, 16)
    image = np.ones((16, 16, 4))
    image[..., :3] = linear_from_srgb(levels)[..., None]
    got = shown(gpu, presenter, image, (16, 16), hardware=hardware)
    assert np.array_equal(got[..., :3], np.repeat(levels[..., None], 3, axis=2))
    assert (got[..., 3] == 255).all()


@WAYS
def test_rows_and_columns_stay_where_they_are_and_only_the_viewport_is_touched(gpu, presenter, hardware):
    image = np.zeros((6, 9, 4))
    image[..., 3] = 1
    image[0, 0, 0] = image[5, 0, 1] = image[0, 8, 2] = 1
    for picture, wanted in ((image, srgb8_from_linear(image[..., :3])), (None, np.zeros((6, 9, 3)))):
        got = shown(gpu, presenter, picture, (21, 17), (5, 4, 9, 6), hardware).copy()
        assert np.array_equal(got[4:10, 5:14, :3], wanted) and (got[4:10, 5:14, 3] == 255).all()
        got[4:10, 5:14] = Screen.UNTOUCHED
        assert (got == Screen.UNTOUCHED).all()


@WAYS
def test_a_hole_is_black_and_what_is_no_light_does_no_harm(gpu, presenter, hardware):
    image = np.full((3, 6, 4), 0.5)
    image[1, 1] = (0.7, 0.7, 0.7, 0)
    image[0, 2, :3] = np.nan
    image[1, 3, :3] = np.inf
    image[2, 4, :3] = -np.inf, -1, 1.5
    wanted = np.full((3, 6, 3), srgb8_from_linear(0.5))
    wanted[1, 1], wanted[0, 2], wanted[1, 3], wanted[2, 4] = 0, 0, 255, (0, 0, 255)
    got = shown(gpu, presenter, image, (6, 3), hardware=hardware)[..., :3]
    assert np.abs(got.astype(int) - wanted).max() <= 1
    assert np.array_equal(got[wanted == 0], wanted[wanted == 0])


def scaled(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """By another route than the shader.

    The two nearest texel centres along each axis, weighted as a triangle of width 1 about them.
    """
    clean = np.where(image[..., 3:] > 0, np.clip(np.nan_to_num(image[..., :3].astype(np.float64)), 0, 1), 0)
    for axis, target in ((0, size[1]), (1, size[0])):
        count = clean.shape[axis]
        at = (np.arange(target) + 0.5) * count / target
        weights = np.maximum(0, 1 - np.abs(at[:, None] - (np.arange(-1, count + 1) + 0.5)))
        weights[:, 1] += weights[:, 0]  # beyond the edge is the edge again
        weights[:, -2] += weights[:, -1]
        clean = np.moveaxis(np.tensordot(weights[:, 1:-1], clean, (1, axis)), 0, axis)
    return clean


@pytest.mark.parametrize("size", [(31, 45), (8, 5), (13, 11), (26, 22)])
def test_another_size_is_bilinear(gpu, presenter, size):
    """float32 weights.

    1e-5 of light at most, which in the steep start of the curve (12.92) is 0.04 of a level; 0.01 as
    in the curve's own test. What lies under alpha 0 is nothing, to its neighbours too.
    """
    image = random_picture(3, 13, 11)
    image[4:6, 5, 3] = 0
    image[4, 5, :3] = np.nan, np.inf, 9
    got = shown(gpu, presenter, image, size)[..., :3]
    assert np.abs(got - 255 * srgb_from_linear(scaled(image, size))).max() <= rounding(gpu) + 0.05


# --- the flags of GL ----------------------------------------------------------------------------


def test_the_state_left_by_others_does_not_matter(gpu, presenter):
    """Blending, culling, depth tests, encoding left on by whoever drew before."""
    image, gl = random_picture(5, 8, 6), gpu.gl
    wanted = shown(gpu, presenter, image, (8, 6))
    screen = Screen(gl, (8, 6), srgb=False)
    with gl.scope(screen.framebuffer, moderngl.BLEND | moderngl.CULL_FACE | moderngl.DEPTH_TEST):
        gl.enable_direct(FRAMEBUFFER_SRGB)
        presenter.show(canvas_of(gl, image), screen.framebuffer, (0, 0, 8, 6), hardware_srgb=False)
    assert np.array_equal(screen.bytes(), wanted)


def test_encoding_is_off_again_afterwards(gpu, presenter):
    """Or the server's own pictures would be encoded.

    A clear tells, for it is encoded like everything else.
    """
    screen = Screen(gpu.gl, (4, 4), srgb=True)
    presenter.show(None, screen.framebuffer, (0, 0, 4, 4), hardware_srgb=True)
    screen.framebuffer.clear(0.5, 0.5, 0.5, 1)
    assert abs(int(screen.bytes()[0, 0, 0]) - 128) <= 1
    assert screen.framebuffer.viewport == (0, 0, 4, 4)


# --- notices ------------------------------------------------------------------------------------

EYES = {
    "symmetric": View(Pose(), Fov.symmetric(1.2, 1.1)),
    "left": View(Pose((1, 2, 3)), Fov(-0.7, 0.5, -0.6, 0.5), Pose((-0.032, 0, 0))),
    "canted": View(
        Pose(),
        Fov(-0.6, 0.6, -0.6, 0.5),
        Pose((0.032, 0.001, -0.01), Rotation.from_rotvec((0.02, -0.1, 0.01)).as_quat()),
    ),
}


def pixels_of(uv: list[tuple[float, float]], uv_from_pixel: np.ndarray) -> np.ndarray:
    at = np.linalg.inv(uv_from_pixel) @ np.column_stack([uv, np.ones(len(uv))]).T
    return (at[:2] / at[2]).T


@pytest.mark.parametrize("eye", EYES)
def test_a_notice_stands_1_m_before_the_head(presenter, eye):
    """By rays instead of the matrix.

    Each pixel's ray through the plane z = -1 m of the head, then along the notice's axes.
    """
    view, size, notice = EYES[eye], (64, 80), presenter.notice("tracking lost")
    uv_from_pixel = notice.uv_from_pixel(size, view)
    pixel = pixels_of([(0, 0), (1, 0), (0, 1), (0.5, 0.5)], uv_from_pixel)
    left, right, down, up = view.fov.tangents
    tangent = np.array([left, down]) + pixel / size * np.array([right - left, up - down])
    rays = np.column_stack([tangent, -np.ones(4)])
    start, turned = view.head_from_eye.position_m, view.head_from_eye.rotation.apply(rays)
    met = start + turned * ((-1 - start[2]) / turned[:, 2])[:, None]
    assert np.allclose(met[:, 2], -1)
    assert np.allclose((met[0] + met[1])[0], 0, atol=1e-9)  # in the middle
    assert met[3][1] == pytest.approx(-0.35)
    w, h = notice.ink.size
    assert (met[1] - met[0])[0] / (met[2] - met[0])[1] == pytest.approx(w / h)
    assert (uv_from_pixel @ [*pixel[3], 1])[2] > 0
    assert ((pixel >= 0) & (pixel <= size)).all()


def test_a_notice_behind_the_eye_is_not_shown(presenter):
    """A homogeneous uv has a mirror image there."""
    turned = View(Pose(), Fov(-0.7, 0.7, -0.7, 0.7), Pose((0, 0, 0), (0, 1, 0, 0)))  # an eye that looks backwards
    corners = [(x, y, 1) for x in (0.5, 63.5) for y in (0.5, 63.5)]
    assert ((corners @ presenter.notice("behind").uv_from_pixel((64, 64), turned).T)[:, 2] < 0).all()


@pytest.mark.parametrize("eye", [None, *EYES])
def test_a_notice_is_laid_over_the_picture_as_its_twin_says(gpu, presenter, eye):
    """Where the notice is not, nothing changes.

    On it, the twin in float64 mixes and samples the finest level; magnified, so that no other level
    is looked at. A texel's weight is good to 1/256 in hardware, and letters differ by 1: two
    levels, doubled by the curve.
    """
    size, notice = (1200, 1000), presenter.notice("Ag")
    view = EYES[eye] if eye else None
    image = random_picture(7, *size)
    got = shown(gpu, presenter, image, size, notice=notice, eye=view)[..., :3].astype(float)
    plain = shown(gpu, presenter, image, size)[..., :3]
    y, x = np.indices(size[::-1]) + 0.5
    q = np.stack([x, y, np.ones_like(x)], -1) @ notice.uv_from_pixel(size, view).T
    uv = q[..., :2] / q[..., 2:]
    inside = (q[..., 2] > 0) & (uv >= 0).all(-1) & (uv < 1).all(-1)
    edge = (np.abs(uv) < 1e-4).any(-1) | (np.abs(uv - 1) < 1e-4).any(-1)  # float32 may put a pixel on either side
    assert inside.sum() > 2000
    assert np.array_equal(got[~inside & ~edge], plain[~inside & ~edge])
    ink = np.frombuffer(notice.ink.read(), np.uint8).reshape(notice.ink.height, notice.ink.width) / 255
    at = (uv[inside] * ink.shape[::-1] - 0.5).T[::-1]
    letter = map_coordinates(ink, at, order=1, mode="nearest")[:, None]
    light = 0.2 * image[inside][:, :3].astype(float) + 0.8 * 0.01
    wanted = 255 * srgb_from_linear(letter + (1 - letter) * light)
    off = np.abs(got[inside] - wanted).max(axis=1)[~edge[inside]]
    # Every view magnifies the notice, by 1.1 and more: none of them asks for a coarser level.
    assert np.quantile(off, 0.99) <= 4
    assert off.max() <= 12


def test_text_is_white_upright_and_wrapped_and_a_tab_makes_columns():
    one, two = text_ink("L"), text_ink("L\nL")
    assert one.max() == 255
    assert two.shape[0] > one.shape[0]
    rows = np.flatnonzero(one.max(axis=1) > 128)
    widths = (one[rows] > 128).sum(axis=1)
    assert widths[-1] > 2 * widths[0]  # the foot of the L is below
    long = text_ink("the head is where it was last seen " * 4)
    assert long.shape[1] < 900
    assert long.shape[0] > 2 * one.shape[0]
    help_text = text_ink("T\tnext warp\nEscape\tnext warp")
    half = help_text.shape[0] // 2
    upper, lower = (np.flatnonzero(part.max(axis=0) > 128) for part in (help_text[:half], help_text[half:]))
    assert upper[-1] == lower[-1]


@pytest.mark.parametrize("size", [(640, 800), (1100, 1000), (96, 120)])
def test_a_long_text_is_all_there(presenter, size):
    """In the place, and in the view of an eye that sees 41 degrees to each side."""
    notice = presenter.notice("\n".join(f"key {i}\twhat it does, in some words" for i in range(20)))
    for view in (None, View(Pose(), Fov.symmetric(1.44, 1.44), Pose((0.034, 0, 0)))):
        pixel = pixels_of([(0, 0), (1, 1)], notice.uv_from_pixel(size, view))
        assert ((pixel >= 0) & (pixel <= size)).all()


# --- depth --------------------------------------------------------------------------------------


def bottom_up(texture: moderngl.Texture) -> np.ndarray:
    return np.frombuffer(texture.read(), np.float32).reshape(texture.size[::-1])


def inverse_of(gl, values: np.ndarray) -> moderngl.Texture:
    texture = allocate(gl, values.shape[::-1], SCALAR)
    upload(texture, values.astype(np.float32))
    return texture


@pytest.mark.parametrize("coloured", [False, True])
def test_depth_is_reversed_and_what_is_unknown_is_infinitely_far(gpu, presenter, coloured):
    gl, near_m = gpu.gl, 0.1
    inverse = np.random.default_rng(8).uniform(0, 12, (7, 9)).astype(np.float32)
    inverse[0, 0], inverse[1, 1], inverse[2, 2], inverse[3, 3] = -1, 0, np.nan, 1e9
    texture = inverse_of(gl, inverse)
    into, screen = gl.depth_texture((9, 7)), Screen(gl, (9, 7), srgb=False)
    framebuffer = gl.framebuffer([screen.texture] if coloured else [], into)
    framebuffer.clear(*(part / 255 for part in Screen.UNTOUCHED), depth=0.3)
    framebuffer.use()  # a mask set while it is bound must tell too
    presenter.depth(texture, framebuffer, near_m)
    got = bottom_up(into)
    known = np.isfinite(inverse) & (inverse > 0)
    wanted = np.where(known, np.minimum(near_m * np.where(known, inverse, 0).astype(np.float64), 1), 0)
    assert np.abs(got - wanted[::-1]).max() < 2**-23  # 24 bits, rounded, and one rounding of float32
    assert download(texture).tobytes() == inverse.tobytes()
    if coloured:
        assert (screen.bytes() == Screen.UNTOUCHED).all()
        framebuffer.clear(1, 1, 1, 1)
        assert (screen.bytes() == 255).all()  # colours may be written again


def test_depth_of_another_size_is_not_mixed(gpu, presenter):
    gl = gpu.gl
    inverse, into = np.random.default_rng(9).choice([-1, 0.5, 2], (6, 4)), gl.depth_texture((8, 12))
    presenter.depth(inverse_of(gl, inverse), gl.framebuffer(depth_attachment=into), 0.25)
    got = bottom_up(into)
    assert np.abs(got - np.kron(np.maximum(0, inverse[::-1]) * 0.25, np.ones((2, 2)))).max() < 2**-23


def test_depth_leaves_the_next_pass_its_depth_test(gpu, presenter):
    """Nearest wins again: a triangle at 0.5 does not go over what is at 0.3."""
    gl, screen = gpu.gl, Screen(gpu.gl, (4, 4), srgb=False)
    framebuffer = gl.framebuffer([screen.texture], gl.depth_texture((4, 4)))
    presenter.depth(inverse_of(gl, np.full((4, 4), 3)), framebuffer, 0.1)
    triangle = gl.vertex_array(
        gpu.shaders.draw("display/whole.vert", "display/picture.frag", ENCODES=0, SCALED=0, NOTICED=0).program, []
    )
    with gl.scope(framebuffer, moderngl.DEPTH_TEST):
        triangle.render(moderngl.TRIANGLES, vertices=3)
    assert (screen.bytes() == Screen.UNTOUCHED).all()
    assert framebuffer.viewport == (0, 0, 4, 4)

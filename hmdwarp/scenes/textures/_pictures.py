"""Printed pictures, sheets with alpha and paintings, (h, w, 3 or 4) uint8 sRGB, top row first."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._surfaces import Field, Image, fractal, over, tinted, to_image, unit_grid

Colour = tuple[float, float, float]

# 5x7 letters: one base-32 digit per row, the most significant of five bits at the left.
_LETTERS = {
    "A": "0EHHVHHH", "B": "UHHUHHU", "C": "EHGGGHE", "D": "UHHHHHU", "E": "VGGUGGV", "F": "VGGUGGG", "G": "EHGNHHE",
    "H": "HHHVHHH", "I": "E44444E", "J": "111111E", "K": "HIKOKIH", "L": "GGGGGGV", "M": "HRLLHHH", "N": "HPPLJJH",
    "O": "EHHHHHE", "P": "UHHUGGG", "R": "UHHUKIH", "S": "FGGE11U", "T": "V444444", "U": "HHHHHHE", "V": "HHHHAA4",
    "W": "HHHLLRH", "X": "HHA4AHH", "Y": "HHA4444", "Z": "V1248GV", "0": "EHJLPHE", "1": "4C4444E", "2": "EH1248V",
    "3": "EH161HE", "4": "26AIV22", "8": "EHHEHHE", "9": "EHHF11E", ":": "0440440", ".": "0000066", " ": "0000000",
}  # fmt: skip


def lettering(text: str, scale: int = 1) -> NDArray[np.bool_]:
    """Return the mask of a line of text, 7 x scale pixels high."""
    gap = np.zeros((7, 1), bool)
    rows = [[int(code, 32) for code in _LETTERS.get(one, _LETTERS[" "])[-7:]] for one in text.upper()]
    glyphs = (np.array(each)[:, None] >> [4, 3, 2, 1, 0] & 1 > 0 for each in rows)
    line = np.concatenate([part for glyph in glyphs for part in (glyph, gap)], axis=1)
    return line.repeat(scale, axis=0).repeat(scale, axis=1)


def stamp(image: NDArray[Any], mask: NDArray[np.bool_], top: int, left: int, colour: Colour) -> None:
    """Paint `mask` onto a (h, w, 3) float picture, clipped at its borders."""
    height, width = image.shape[:2]
    mask = mask[: max(height - top, 0), : max(width - left, 0)]
    image[top : top + mask.shape[0], left : left + mask.shape[1]][mask] = colour


_WORDS = "LATENCY POSE EYE LENS FRAME DEPTH HOLE PARALLAX LIGHT FIELD VIEW HEAD GAZE WARP FILL RAY EDGE MOTION PIXEL"


def _paragraph(
    image: NDArray[Any], rng: np.random.Generator, *, top: int, left: int, width: int, lines: int, colour: Colour
) -> None:
    for line in range(lines):
        words = ""
        while len(words) * 6 < width - 40:
            words += str(rng.choice(_WORDS.split())) + " "
        stamp(image, lettering(words)[:, :width], top + line * 10, left, colour)


def poster(index: int, height: int = 384, width: int = 256) -> Image:
    """Paint one of four posters: rings, mountains, a grid of colour fields, a text page."""
    rng = np.random.default_rng(200 + index)
    y, x = np.meshgrid(np.arange(height) / height, np.arange(width) / width * width / height, indexing="ij")
    paper = np.array([(0.93, 0.88, 0.76), (0.12, 0.17, 0.29), (0.90, 0.90, 0.88), (0.95, 0.93, 0.88)][index % 4])
    ink = [(0.16, 0.14, 0.16), (0.95, 0.88, 0.70), (0.12, 0.12, 0.14), (0.18, 0.17, 0.20)][index % 4]
    image = np.tile(paper, (height, width, 1))
    if index % 4 == 0:
        radius = np.hypot(x - 0.333, y - 0.42)
        image = np.where(((radius * 26) % 1 < 0.5)[..., None] & (radius < 0.27)[..., None], (0.80, 0.28, 0.18), image)
    elif index % 4 == 1:
        for layer in range(5):
            ridge = 0.35 + 0.09 * layer + 0.05 * fractal(1, width, 300 + layer, 1.3)[0]
            tone = np.array((0.85, 0.45, 0.35)) * (1 - layer / 5) + np.array((0.12, 0.18, 0.32)) * layer / 5
            image = over(image, (y > ridge) & (y < 0.82), tone)
        image = over(image, np.hypot(x - 0.45, y - 0.22) < 0.08, (0.98, 0.83, 0.50))
    elif index % 4 == 2:
        tones = rng.uniform(0.15, 0.95, (6, 4, 3))
        cells = tones[np.clip((y * 8 - 0.4).astype(int), 0, 5), np.clip((x * 6).astype(int), 0, 3)]
        image = np.where(
            ((y * 8 - 0.4) % 1 > 0.1)[..., None] & (y < 0.79)[..., None] & (y > 0.05)[..., None], cells, image
        )
    else:
        _paragraph(image, rng, top=92, left=20, width=width - 40, lines=20, colour=ink)
    title = ["PARALLAX", "FAR VIEW", "COLOUR 24", "ON LATENCY"][index % 4]
    stamp(image, lettering(title, 4), 22 if index % 4 == 3 else height - 62, 16, ink)
    _paragraph(image, rng, top=60 if index % 4 == 3 else height - 28, left=16, width=width - 32, lines=2, colour=ink)
    return to_image(image + 0.015 * fractal(height, width, 400 + index, 0.3)[..., None])


def posters() -> Image:
    """Paint the four posters side by side, 384 high and 1024 wide."""
    return np.concatenate([poster(i) for i in range(4)], axis=1)


SPINES = 32
_CLOTHS = [
    (0.55, 0.16, 0.13),
    (0.13, 0.26, 0.40),
    (0.16, 0.34, 0.24),
    (0.78, 0.66, 0.42),
    (0.28, 0.20, 0.32),
    (0.85, 0.82, 0.74),
    (0.20, 0.20, 0.22),
    (0.72, 0.40, 0.16),
]


def book_spines(height: int = 256, width: int = 1024, seed: int = 500) -> Image:
    """Paint SPINES book spines side by side."""
    rng = np.random.default_rng(seed)
    image = np.empty((height, width, 3))
    each = width // SPINES
    for i in range(SPINES):
        cloth = np.array(rng.choice(_CLOTHS))
        spine = np.tile(cloth * rng.uniform(0.8, 1.15), (height, each, 1))
        gold = (0.90, 0.78, 0.45) if cloth.mean() < 0.6 else (0.25, 0.15, 0.12)
        for band in rng.integers(8, 30, 2):
            spine[band : band + 3] = gold
            spine[height - band - 3 : height - band] = gold
        title = lettering(f"{rng.choice(_WORDS.split())} {rng.choice(_WORDS.split())}", 2)[:, : height - 90]
        stamp(spine, np.rot90(title, -1), 46, (each - 14) // 2, gold)
        edge = np.abs(np.linspace(-1, 1, each))[:, None]
        image[:, i * each : (i + 1) * each] = spine * (1 - 0.35 * edge**3)
    return to_image(image + 0.03 * fractal(height, width, seed + 1, 0.4)[..., None])


def dials(width: int = 1024, height: int = 320, seed: int = 860) -> Image:
    """Paint round instruments with ticks and hands, and switches below."""
    rng = np.random.default_rng(seed)
    image = tinted(0.5 + 0.2 * fractal(height, width, seed, 0.3), (0.10, 0.11, 0.12), (0.19, 0.20, 0.21)).copy()
    y, x = np.mgrid[:height, :width].astype(np.float32)
    for k in range(6):
        cx, cy, radius = 100 + 165 * k, 125, 68
        dx, dy = x - cx, cy - y
        far, angle = np.hypot(dx, dy), np.arctan2(dx, dy)
        image[far < radius] = (0.03, 0.03, 0.035)
        image[np.abs(far - radius) < 3] = (0.62, 0.63, 0.64)
        tick = np.abs(angle * 24 / np.pi / 2 - np.round(angle * 24 / np.pi / 2)) < 0.10
        image[tick & (far > 0.78 * radius) & (far < 0.92 * radius)] = (0.9, 0.9, 0.86)
        hand = rng.uniform(-2.4, 2.4)
        along, off = dx * np.sin(hand) + dy * np.cos(hand), dx * np.cos(hand) - dy * np.sin(hand)
        image[(along > -8) & (along < 0.72 * radius) & (np.abs(off) < 2.6)] = (0.95, 0.45, 0.15)
        stamp(
            image, lettering(("ALT", "KNOT", "FUEL", "TURN", "VOLT", "HEAD")[k], 2), cy + 22, cx - 22, (0.85, 0.85, 0.8)
        )
    for k in range(14):
        left = 60 + 66 * k
        image[245:285, left : left + 22] = (0.5, 0.5, 0.52)
        image[250 + 14 * (k % 2) : 266 + 14 * (k % 2), left + 3 : left + 19] = (
            (0.85, 0.2, 0.15) if k % 5 == 0 else (0.9, 0.9, 0.9)
        )
    return to_image(image)


def flag(height: int = 256, width: int = 384) -> Image:
    """Paint a flag of stripes and a ring of dots."""
    y, x = unit_grid(height, width)
    stripe = (y * 5).astype(int) % 2
    image = np.where(stripe[..., None] == 0, (0.78, 0.16, 0.14), (0.95, 0.92, 0.84))
    u, v = (x - 0.3) * width / height, y - 0.5
    disc = np.hypot(u, v) < 0.34
    image = over(image, disc, (0.14, 0.24, 0.46))
    for angle in np.arange(12) * np.pi / 6:
        dot = np.hypot(u - 0.25 * np.cos(angle), v - 0.25 * np.sin(angle)) < 0.035
        image = over(image, dot, (0.95, 0.80, 0.30))
    weave = 0.03 * fractal(height, width, 900, 0.2) + 0.03 * fractal(height, width, 901, 1.2)
    return to_image(image + weave[..., None])


def with_alpha(colour: ArrayLike, alpha: NDArray[Any]) -> Image:
    """Return one sRGB colour, or a (h, w, 3) picture, with (h, w) alpha, all of 0..1."""
    height, width = alpha.shape
    picture = np.broadcast_to(np.asarray(colour, np.float32), (height, width, 3))
    return to_image(np.concatenate([picture, np.clip(alpha, 0, 1)[..., None]], axis=2))


def dusty_glass(words: tuple[str, ...], size: int = 512, seed: int = 800) -> Image:
    """Paint a pane with rain-streaked dust, dirt in its corners and lettering."""
    y, x = np.meshgrid(np.linspace(0, 1, size), np.linspace(0, 1, size), indexing="ij")
    film = 0.10 + 0.035 * fractal(size, size, seed, 1.3) + 0.03 * fractal(size, size, seed + 1, 0.6, (0.12, 1.0))
    specks = np.clip(fractal(size, size, seed + 2, 0.55) - 2.3, 0, 1) * 0.5
    from_edge = np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y))
    mud = np.clip(5 * (y - 0.82), 0, 1) * np.clip(0.6 + 0.4 * fractal(size, size, seed + 3, 1.1), 0, 1)
    rim = 0.35 * np.exp(-from_edge / 0.02) + 0.22 * mud
    alpha = np.clip(film, 0.04, 1) + specks + rim
    colour = np.broadcast_to(np.array((0.80, 0.79, 0.72), np.float32), (size, size, 3)).copy()
    scale = round(0.8 * size / (6 * max(map(len, words), default=1)))
    for line, word in enumerate(words):
        mask = lettering(word, scale)
        top, left = round(size * 0.24) + 9 * scale * line, (size - mask.shape[1]) // 2
        area = np.s_[top : top + mask.shape[0], left : left + mask.shape[1]]
        alpha[area] = np.where(mask, 0.92, alpha[area])
        colour[area] = over(colour[area], mask, (0.93, 0.90, 0.78))
    return with_alpha(colour, alpha)


def leaded_glass(size: int = 256, seed: int = 820) -> Image:
    """Paint a thin film of dust over diamonds of lead."""
    y, x = unit_grid(size, size)
    lead = np.minimum(_to_line((x + y) * 3), _to_line((x - y) * 3)) < 0.035
    film = np.clip(0.12 + 0.03 * fractal(size, size, seed, 1.0), 0.05, 0.4)
    return with_alpha(np.where(lead[..., None], (0.16, 0.16, 0.17), (0.85, 0.85, 0.8)), np.where(lead, 1.0, film))


def _to_line(value: Field) -> Field:
    """Return the distance to the nearest integer."""
    return np.abs(value - np.round(value))


def pickets(size: int = 256, seed: int = 840) -> Image:
    """Paint two pointed laths and two rails behind them, with air between."""
    y, x = np.meshgrid(np.linspace(1, 0, size), np.arange(size) / size * 2, indexing="ij")
    across = np.abs(x % 1 - 0.5)
    lath = (across < 0.27) & (y < 0.98 - 0.42 * across)
    rail = (np.abs(y - 0.26) < 0.055) | (np.abs(y - 0.72) < 0.055)
    grain = 0.6 + 0.14 * fractal(size, size, seed, 0.9, (0.15, 1.0)) + 0.05 * fractal(size, size, seed + 1, 0.2)
    colour = tinted(grain * np.where(lath, 1.0, 0.7), (0.34, 0.24, 0.16), (0.90, 0.84, 0.72))
    return with_alpha(colour, (lath | rail).astype(np.float32))


def head_up(size: int = 768) -> Image:
    """Paint a head-up display: crosshair, pitch ladder, heading marks and readings."""
    y, x = np.meshgrid(np.linspace(1, -1, size), np.linspace(-1, 1, size), indexing="ij")
    far, line = np.hypot(x, y), 2.4 / size
    lit = (np.abs(far - 0.16) < line) | ((np.minimum(np.abs(x), np.abs(y)) < line) & (far > 0.05) & (far < 0.12))
    for step in (-3, -2, -1, 1, 2, 3):
        bar = (np.abs(y - 0.17 * step) < line) & (np.abs(x) > 0.2) & (np.abs(x) < 0.42 - 0.03 * abs(step))
        lit |= bar & ((step > 0) | ((x * 24).astype(int) % 2 == 0))
    lit |= (
        (np.abs(_to_line(x * 10)) < line * 8)
        & (np.abs(x) < 0.72)
        & (y > 0.78)
        & (y < np.where(_to_line(x * 5) < 0.05, 0.86, 0.82))
    )
    lit |= (np.abs(y - 0.78) < line) & (np.abs(x) < 0.72)
    for side in (-1, 1):
        lit |= (np.abs(x - side * 0.66) < line) & (np.abs(y) < 0.5)
        lit |= (np.abs(_to_line(y * 12)) < line * 10) & (side * x > 0.66) & (side * x < 0.71) & (np.abs(y) < 0.5)
    lit = lit.astype(np.float32)
    places = {
        "080": (0.055, 0.455),
        "LATENCY": (0.90, 0.08),
        "1240": (0.45, 0.86),
        "148": (0.45, 0.05),
        "HOLD": (0.9, 0.8),
    }
    for text, (down, across) in places.items():
        mask = lettering(text, 3)
        top, left = round(down * size), round(across * size)
        area = lit[top : top + mask.shape[0], left : left + mask.shape[1]]
        area[mask[: area.shape[0], : area.shape[1]]] = 1
    glow = np.clip(
        0.06 - 0.05 * np.maximum(np.abs(x), np.abs(y)) ** 4, 0, 1
    )  # the glass itself, so that its border shows
    return with_alpha((0.42, 1.0, 0.55), np.maximum(0.95 * lit, glow * (np.maximum(np.abs(x), np.abs(y)) < 0.97)))


def page(lines: int = 22, width: int = 1024, seed: int = 980) -> Image:
    """Paint a page of text, dark on bright, below a title: small letters are 7 texels high."""
    image, rng = np.full((60 + 2 * 12 * lines, width, 3), 0.94), np.random.default_rng(seed)
    stamp(image, lettering("A LATE FRAME AND THE NEWEST POSE", 4), 14, 24, (0.10, 0.14, 0.32))
    for line in range(lines):
        words = " ".join(rng.choice(_WORDS.split(), 1 + width // 84))
        stamp(image, lettering(words, 2)[:, : width - 48], 56 + 24 * line, 24, (0.12, 0.12, 0.14))
    return to_image(image)


def label(text: str) -> Image:
    """Paint a line of bright text on a dark ground that half of the light passes."""
    mask = np.pad(lettering(text, 4), 10)
    return with_alpha(np.where(mask[..., None], (0.95, 0.97, 1.0), (0.04, 0.05, 0.08)), np.where(mask, 1.0, 0.5))


COLUMNS, ROWS = 4, 2  # of the paintings in their picture
PALETTES = (
    ((0.06, 0.10, 0.26), (0.95, 0.78, 0.36), (0.75, 0.25, 0.18)),
    ((0.10, 0.24, 0.20), (0.90, 0.86, 0.66), (0.20, 0.55, 0.60)),
    ((0.22, 0.06, 0.10), (0.98, 0.66, 0.42), (0.50, 0.14, 0.30)),
    ((0.08, 0.08, 0.10), (0.92, 0.92, 0.90), (0.85, 0.16, 0.12)),
)


def painting(index: int, height: int = 384, width: int = 320) -> Image:
    """Paint one of eight: skies over land, drifts of colour, stripes, discs."""
    dark, bright, third = (np.array(colour) for colour in PALETTES[index % 4])
    y, x = np.meshgrid(np.linspace(0, 1, height), np.linspace(0, 1, width), indexing="ij")
    rough, soft = (fractal(height, width, 900 + 10 * index + k, exponent) for k, exponent in ((0, 0.9), (1, 1.8)))
    kind = index // 2
    if kind == 0:
        image = tinted(1.1 - y + 0.10 * soft, dark, bright)
        land = y > 0.62 + 0.06 * soft[height // 2][None]
        image = over(image, land, third * (0.35 + 0.9 * (1 - y))[..., None] * (1 + 0.16 * rough)[..., None])
    elif kind == 1:
        flow = np.sin(9 * x + 3.5 * soft) * np.cos(7 * y + 2.5 * np.roll(soft, 60, axis=1))
        image = tinted(0.5 + 0.5 * flow, dark, bright)
        image = over(image, np.abs(flow) < 0.22, third)
    elif kind == 2:
        edges = np.sort(np.random.default_rng(950 + index).uniform(0, 1, 13))
        which = np.searchsorted(edges, x + 0.015 * soft)
        image = np.array([dark, bright, third, 0.5 * (dark + bright)])[which % 4]
    else:
        image = np.tile(bright, (height, width, 1))
        for centre, radius, colour in (
            ((0.42, 0.38), 0.30, third),
            ((0.62, 0.60), 0.24, dark),
            ((0.33, 0.72), 0.13, 0.5 * (third + dark)),
        ):
            image = over(image, np.hypot(x - centre[0], (y - centre[1]) * height / width) < radius, colour)
    canvas = 0.03 * np.sin(x * width * 1.6) * np.sin(y * height * 1.6)
    return to_image(image * (1 + canvas + 0.07 * rough)[..., None])


def paintings() -> Image:
    """Paint all of them in COLUMNS x ROWS."""
    return np.concatenate(
        [np.concatenate([painting(row * COLUMNS + k) for k in range(COLUMNS)], axis=1) for row in range(ROWS)]
    )


def marble(size: int = 1024, tiles: int = 4, seed: int = 960) -> Image:
    """Paint 3.2 m of alternating slabs of light and dark veined marble."""
    warp = fractal(size, size, seed, 1.5)
    vein = np.exp(-np.abs(np.roll(fractal(size, size, seed + 1, 1.25), 37, axis=0) + 0.35 * warp) * 7)
    cloud = 0.6 + 0.16 * fractal(size, size, seed + 2, 0.9)
    index = np.arange(size) * tiles // size
    tone = np.random.default_rng(seed).normal(0, 0.05, (tiles, tiles))[index[:, None], index][..., None]
    light = tinted(cloud, (0.66, 0.63, 0.58), (0.90, 0.88, 0.84)) * (1 - 0.35 * vein[..., None])
    dark = tinted(cloud, (0.20, 0.22, 0.24), (0.36, 0.38, 0.40)) + 0.35 * vein[..., None]
    image = np.where(((index[:, None] + index) % 2 == 0)[..., None], light, dark) + tone
    within = np.arange(size) % (size // tiles)
    joint = np.minimum(within, size // tiles - 1 - within) < 1
    return to_image(over(image, joint[:, None] | joint, (0.24, 0.23, 0.22)))


def ripples(size: int = 256, seed: int = 970, slope: float = 0.25) -> Image:
    """Return tangent-space normals of 3.2 m of a hand-polished floor, in waves of at least 20 cm.

    slope: the mean. Byte 127 is 0, and a step of a byte a slope of 0.008: a small normal_scale
    hides the steps.
    """
    fy, fx = np.fft.fftfreq(size)[:, None] * size, np.fft.rfftfreq(size)[None] * size
    white = np.fft.rfft2(np.random.default_rng(seed).standard_normal((size, size)))
    smooth = white * np.exp(-((np.hypot(fy, fx) / 9) ** 2))
    along = [np.fft.irfft2(1j * f * smooth, s=(size, size)) for f in (fx, -fy)]  # rows run down, v runs up
    scale = slope / np.hypot(*along).mean()
    normal = np.stack([-along[0] * scale, -along[1] * scale, np.ones((size, size))], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return np.clip(np.round(normal * 127.5 + 127), 0, 255).astype(np.uint8)

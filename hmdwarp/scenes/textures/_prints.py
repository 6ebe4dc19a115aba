"""Printed pictures, (h, w, 3) uint8 sRGB: lettering, posters, book spines, dials, a flag."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ._noise import Image, fractal, tinted, to_image, unit_grid

Colour = tuple[float, float, float]

# 5x7 letters: one base-32 digit per row, the most significant of five bits at the left.
_LETTERS = {
    "A": "0EHHVHHH", "B": "UHHUHHU", "C": "EHGGGHE", "D": "UHHHHHU", "E": "VGGUGGV", "F": "VGGUGGG", "G": "EHGNHHE",
    "H": "HHHVHHH", "I": "E44444E", "J": "111111E", "K": "HIKOKIH", "L": "GGGGGGV", "M": "HRLLHHH", "N": "HPPLJJH",
    "O": "EHHHHHE", "P": "UHHUGGG", "R": "UHHUKIH", "S": "FGGE11U", "T": "V444444", "U": "HHHHHHE", "V": "HHHHAA4",
    "W": "HHHLLRH", "X": "HHA4AHH", "Y": "HHA4444", "Z": "V1248GV", "0": "EHJLPHE", "1": "4C4444E", "2": "EH1248V",
    "3": "EH161HE", "4": "26AIV22", "8": "EHHEHHE", "9": "EHHF11E", ":": "0440440", ".": "0000066", " ": "0000000",
}  # fmt: skip


def _glyph(letter: str) -> NDArray[np.bool_]:
    rows = [int(code, 32) for code in _LETTERS.get(letter, _LETTERS[" "])[-7:]]
    return np.array([[bool(row >> bit & 1) for bit in (4, 3, 2, 1, 0)] for row in rows])


def lettering(text: str, scale: int = 1) -> NDArray[np.bool_]:
    """Return the mask of a line of text, 7 x scale pixels high."""
    gap = np.zeros((7, 1), bool)
    line = np.concatenate([part for letter in text.upper() for part in (_glyph(letter), gap)], axis=1)
    return line.repeat(scale, axis=0).repeat(scale, axis=1)


def stamp(image: NDArray, mask: NDArray[np.bool_], top: int, left: int, colour: Colour) -> None:
    """Paint `mask` onto a (h, w, 3) float picture, clipped at its borders."""
    height, width = image.shape[:2]
    mask = mask[: max(height - top, 0), : max(width - left, 0)]
    image[top : top + mask.shape[0], left : left + mask.shape[1]][mask] = colour


_WORDS = "LATENCY POSE EYE LENS FRAME DEPTH HOLE PARALLAX LIGHT FIELD VIEW HEAD GAZE WARP FILL RAY EDGE MOTION PIXEL"


def _paragraph(
    image: NDArray, rng: np.random.Generator, *, top: int, left: int, width: int, lines: int, colour: Colour
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
            image = np.where(((y > ridge) & (y < 0.82))[..., None], tone, image)
        image = np.where((np.hypot(x - 0.45, y - 0.22) < 0.08)[..., None], (0.98, 0.83, 0.50), image)
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
    image = np.where(disc[..., None], (0.14, 0.24, 0.46), image)
    for angle in np.arange(12) * np.pi / 6:
        dot = np.hypot(u - 0.25 * np.cos(angle), v - 0.25 * np.sin(angle)) < 0.035
        image = np.where(dot[..., None], (0.95, 0.80, 0.30), image)
    weave = 0.03 * fractal(height, width, 900, 0.2) + 0.03 * fractal(height, width, 901, 1.2)
    return to_image(image + weave[..., None])

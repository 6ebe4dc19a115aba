"""Tiling pictures of materials, (h, w, 3) uint8 sRGB, made of seeded noise and a few shapes."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Image = NDArray[np.uint8]  # (h, w, 3 or 4), top row first
Field = NDArray[np.floating]  # (h, w)


@cache
def fractal(
    height: int, width: int, seed: int, exponent: float = 1.0, stretch: tuple[float, float] = (1.0, 1.0)
) -> NDArray[np.float32]:
    """Return tiling noise (height, width) with mean 0 and deviation 1.

    exponent: of the frequency; 0 is white, 1 pink, 2 smooth noise. stretch: factors down and
    across.
    """
    white = np.random.default_rng(seed).standard_normal((height, width), dtype=np.float32)
    fy = np.fft.fftfreq(height)[:, None] * height * stretch[0]
    fx = np.fft.rfftfreq(width)[None] * width * stretch[1]
    amplitude = np.maximum(np.hypot(fy, fx), 1.0) ** -exponent
    amplitude[0, 0] = 0
    field = np.fft.irfft2(np.fft.rfft2(white) * amplitude, s=(height, width)).astype(np.float32)
    field /= field.std()
    field.flags.writeable = False
    return field


def to_image(colour: NDArray[Any]) -> Image:
    """Convert (h, w, 3 or 4) sRGB values of 0..1 to bytes."""
    return np.asarray((np.clip(colour, 0, 1) * 255 + 0.5).astype(np.uint8))


def tinted(value: Field, dark: ArrayLike, bright: ArrayLike) -> NDArray[Any]:
    """Return (h, w, 3) sRGB between two colours, by a field of 0..1."""
    low, high = np.asarray(dark, np.float32), np.asarray(bright, np.float32)
    return low + np.clip(value, 0, 1)[..., None] * (high - low)


def over(image: NDArray[Any], mask: NDArray[np.bool_], colour: ArrayLike) -> NDArray[Any]:
    """Return the picture with a colour, or another picture, where the (h, w) mask is."""
    return np.where(mask[..., None], colour, image)


def unit_grid(height: int, width: int) -> tuple[Field, Field]:
    """Return (h, w) places y and x from 0 at the top left towards 1."""
    y, x = np.meshgrid(np.arange(height) / height, np.arange(width) / width, indexing="ij")
    return y, x


def planks(size: int = 1024, count: int = 14, seed: int = 11) -> Image:
    """Paint 2 m of floor boards that run up the picture."""
    rng = np.random.default_rng(seed)
    column = np.arange(size) * count // size
    within = (np.arange(size) * count / size) % 1
    row = np.arange(size)[:, None] / size
    joint = rng.uniform(0, 1, count)[column]
    piece = ((row - joint) % 1 > 0.5).astype(int) + 2 * column
    tone = rng.normal(0.5, 0.17, 2 * count)[piece].astype(np.float32)
    grain = fractal(size, size, seed + 1, 1.1, (9.0, 1.0))
    fine = fractal(size, size, seed + 2, 0.45, (6.0, 1.0))
    value = tone + 0.10 * grain + 0.05 * fine
    image = tinted(value, (0.30, 0.18, 0.10), (0.80, 0.59, 0.38))
    gap = np.minimum(within, 1 - within) * size / count
    seam = np.minimum(np.abs((row - joint) % 0.5), 0.5 - np.abs((row - joint) % 0.5)) * size
    dark = np.clip(np.minimum(gap[None], seam) / 2.2, 0.25, 1)
    return to_image(image * dark[..., None])


def wood(
    size: int = 512, seed: int = 21, dark: ArrayLike = (0.25, 0.14, 0.08), bright: ArrayLike = (0.66, 0.44, 0.27)
) -> Image:
    """Paint furniture wood with its grain along u."""
    rings = fractal(size, size, seed, 1.6, (1.0, 7.0))
    value = (
        0.5
        + 0.22 * np.sin(rings * 7)
        + 0.12 * fractal(size, size, seed + 1, 0.8, (1.0, 10.0))
        + 0.04 * fractal(size, size, seed + 2, 0.2)
    )
    return to_image(tinted(value, dark, bright))


def bricks(size: int = 512, rows: int = 12, columns: int = 4, seed: int = 31) -> Image:
    """Paint old bricks with mortar, 1 m across and 0.9 m high."""
    rng = np.random.default_rng(seed)
    y = np.arange(size) * rows / size
    row = y.astype(int)
    x = np.arange(size)[None] * columns / size + 0.5 * (row[:, None] % 2) + columns
    column = x.astype(int) % columns
    tone = rng.normal(0.5, 0.2, (rows, columns))[row[:, None], column].astype(np.float32)
    wobble = fractal(size, size, seed + 1, 1.0) * 0.018
    edge_y = np.minimum(y % 1, 1 - y % 1)[:, None] / rows + wobble * 0.1
    edge_x = np.minimum(x % 1, 1 - x % 1) / columns + wobble * 0.1
    inside = np.clip((np.minimum(edge_x, edge_y) - 0.0055) / 0.005, 0, 1)
    value = tone + 0.11 * fractal(size, size, seed + 2, 0.6) + 0.06 * fractal(size, size, seed + 3, 0.0)
    brick = tinted(value, (0.40, 0.20, 0.15), (0.80, 0.50, 0.38)) * (
        0.85 + 0.15 * np.clip((y % 1)[:, None, None] * 4, 0, 1)
    )
    mortar = tinted(0.5 + 0.2 * fractal(size, size, seed + 4, 0.4), (0.55, 0.52, 0.48), (0.76, 0.73, 0.68))
    return to_image(mortar + inside[..., None] * (brick - mortar))


def wallpaper(size: int = 512, seed: int = 41) -> Image:
    """Paint 0.8 m of wallpaper: leaves in offset rows on a striped ground."""
    y, x = unit_grid(size, size)
    cell_y, cell_x = y * 4, x * 4 + 0.5 * ((y * 4).astype(int) % 2)
    u, v = cell_x % 1 - 0.5, cell_y % 1 - 0.5
    angle, radius = np.arctan2(u, v), np.hypot(u, v)
    petals = radius < 0.20 + 0.14 * np.cos(angle * 5) * np.cos(angle)
    veins = np.abs(np.sin(angle * 10)) * np.clip(radius * 5, 0, 1)
    dots = np.hypot(np.abs(u) - 0.40, np.abs(v) - 0.38) < 0.035
    stem = (np.abs(u + 0.07 * np.sin(cell_y * 2 * np.pi)) < 0.012) & ~petals
    ground = tinted(
        0.5 + 0.18 * np.sin(x * 2 * np.pi * 32) + 0.1 * fractal(size, size, seed, 0.5),
        (0.66, 0.71, 0.66),
        (0.80, 0.83, 0.76),
    )
    motif = tinted(
        0.3 + 0.6 * veins + 0.08 * fractal(size, size, seed + 1, 0.3), (0.20, 0.36, 0.36), (0.52, 0.64, 0.56)
    )
    image = np.where(petals[..., None], motif, ground)
    image = over(image, stem, (0.42, 0.52, 0.46))
    return to_image(over(image, dots, (0.76, 0.58, 0.30)))


def plaster(size: int = 512, seed: int = 51) -> Image:
    """Paint bright rough plaster with soft stains."""
    value = 0.6 + 0.12 * fractal(size, size, seed, 0.35) + 0.07 * fractal(size, size, seed + 1, 1.1)
    return to_image(tinted(value, (0.74, 0.72, 0.68), (0.97, 0.95, 0.92)))


def fabric(size: int = 256, seed: int = 61) -> Image:
    """Paint 0.25 m of a coarse weave in neutral grey, to be tinted."""
    y, x = np.meshgrid(np.arange(size), np.arange(size), indexing="ij")
    weave = 0.5 + 0.25 * np.where(((x // 4) + (y // 4)) % 2, np.sin(x * np.pi / 4), np.sin(y * np.pi / 4))
    value = weave + 0.12 * fractal(size, size, seed, 0.2) + 0.12 * fractal(size, size, seed + 1, 1.3)
    return to_image(tinted(value, (0.50, 0.50, 0.50), (0.98, 0.98, 0.98)))


def speckle(size: int = 256, seed: int = 71) -> Image:
    """Paint faint mottling for painted, glazed and metal surfaces, to be tinted."""
    value = 0.6 + 0.14 * fractal(size, size, seed, 0.4) + 0.08 * fractal(size, size, seed + 1, 1.1)
    return to_image(tinted(value, (0.76, 0.76, 0.76), (1.0, 1.0, 1.0)))


def foliage(size: int = 256, seed: int = 81) -> Image:
    """Paint a leaf in green grey, its base at the bottom, to be tinted."""
    y, x = np.meshgrid(np.linspace(1, 0, size), np.linspace(-1, 1, size), indexing="ij")
    side = np.abs(np.sin((y * 9 - np.abs(x) * 2.2) * np.pi))
    value = 0.55 + 0.16 * side + 0.12 * fractal(size, size, seed, 0.8)
    image = tinted(value, (0.34, 0.50, 0.26), (0.72, 0.86, 0.52))
    rib = np.clip(np.minimum(np.abs(x) / 0.05, side / 0.12), 0, 1)[..., None]
    return to_image(image * rib + np.array((0.80, 0.88, 0.62)) * (1 - rib))


def grass(size: int = 512, seed: int = 91) -> Image:
    """Paint a meadow: blotches of tone over fine blades."""
    value = 0.5 + 0.16 * fractal(size, size, seed, 1.2) + 0.16 * fractal(size, size, seed + 1, 0.25, (1.0, 2.0))
    return to_image(tinted(value, (0.22, 0.34, 0.12), (0.62, 0.70, 0.34)))


def roof(size: int = 256, rows: int = 12, seed: int = 101) -> Image:
    """Paint rows of roof tiles."""
    rng = np.random.default_rng(seed)
    y, x = np.meshgrid(np.arange(size) * rows / size, np.arange(size) * rows / size, indexing="ij")
    x = x + 0.5 * (y.astype(int) % 2)
    tone = rng.normal(0.5, 0.16, (rows, rows))[y.astype(int), x.astype(int) % rows]
    value = (
        tone + 0.1 * fractal(size, size, seed + 1, 0.3) + 0.25 * (y % 1) - 0.3 * (np.minimum(x % 1, 1 - x % 1) < 0.06)
    )
    return to_image(tinted(value, (0.36, 0.16, 0.12), (0.78, 0.42, 0.30)))


def facade(size: int = 512, columns: int = 4, rows: int = 3, seed: int = 111) -> Image:
    """Paint a house front with framed windows, to be tinted."""
    rng = np.random.default_rng(seed)
    y, x = np.meshgrid(np.arange(size) / size * rows, np.arange(size) / size * columns, indexing="ij")
    u, v, cell = x % 1, y % 1, (y.astype(int) * columns + x.astype(int))
    wall = tinted(
        0.55 + 0.1 * fractal(size, size, seed, 0.4) + 0.1 * fractal(size, size, seed + 1, 1.2),
        (0.68, 0.66, 0.62),
        (0.98, 0.96, 0.92),
    )
    frame = (np.abs(u - 0.5) < 0.24) & (np.abs(v - 0.52) < 0.31)
    glass = (
        (np.abs(u - 0.5) < 0.20) & (np.abs(v - 0.52) < 0.27) & (np.abs(u - 0.5) > 0.018) & (np.abs(v - 0.42) > 0.014)
    )
    pane = tinted(
        rng.uniform(0.1, 1.0, rows * columns)[cell] * 0.7 + 0.3 * (1 - v), (0.10, 0.13, 0.18), (0.55, 0.64, 0.74)
    )
    image = np.where(frame[..., None], (0.95, 0.95, 0.93), wall)
    image = over(image, glass, pane)
    sill = (np.abs(u - 0.5) < 0.27) & (np.abs(v - 0.85) < 0.02)
    return to_image(over(image, sill, (0.58, 0.56, 0.53)))


def perforated(size: int = 128) -> Image:
    """Paint fine holes in offset rows for grilles, to be tinted."""
    y, x = np.meshgrid(np.arange(size) * 8 / size, np.arange(size) * 8 / size, indexing="ij")
    u, v = (x + 0.5 * (y.astype(int) % 2)) % 1 - 0.5, y % 1 - 0.5
    return to_image(tinted(np.clip((np.hypot(u, v) - 0.26) / 0.08, 0, 1), (0.16, 0.16, 0.17), (0.88, 0.88, 0.88)))


def globe(height: int = 256, width: int = 512, seed: int = 121) -> Image:
    """Paint a map of the world with meridians."""
    land = fractal(height, width, seed, 1.7)
    sea = tinted(0.5 + 0.2 * fractal(height, width, seed + 1, 0.8), (0.14, 0.34, 0.50), (0.30, 0.54, 0.68))
    soil = tinted(0.5 + 0.3 * fractal(height, width, seed + 2, 0.9), (0.50, 0.55, 0.26), (0.82, 0.70, 0.44))
    image = np.where((land > 0.35)[..., None], soil, sea)
    image = over(image, np.abs(land - 0.35) < 0.05, (0.25, 0.2, 0.12))
    lines = (np.arange(width) % 32 == 0)[None] | (np.arange(height) % 32 == 0)[:, None]
    return to_image(over(image, lines, image * 0.6))


def rug(y: Field, x: Field, seed: int = 131) -> NDArray[Any]:
    """Return (h, w, 3) sRGB of 0..1 of a knotted rug at places y and x of 0..1 on it."""
    inset = np.minimum(np.minimum(x, 1 - x) * 1.1, np.minimum(y, 1 - y))
    u, v = np.abs(x - 0.5) * 2.2, np.abs(y - 0.5) * 2
    ground = tinted(0.35 + 0.12 * fractal(*y.shape, seed, 0.3), (0.36, 0.07, 0.08), (0.68, 0.20, 0.16))
    star = u + v + 0.08 * np.cos(np.arctan2(v, u) * 16)
    rings = np.select([star < 0.16, star < 0.24, star < 0.42, star < 0.48], [0, 1, 2, 1], -1)
    dots = np.hypot((x * 26) % 1 - 0.5, (y * 22) % 1 - 0.5) < 0.2
    border = np.select([inset < 0.012, inset < 0.035, inset < 0.095, inset < 0.115], [1, 3, 2, 1], -1)
    teeth = (((x + y) * 34) % 1 < 0.5) ^ (((x - y) * 34) % 1 < 0.5)
    palette = np.array([(0.80, 0.60, 0.28), (0.88, 0.80, 0.64), (0.12, 0.20, 0.34), (0.28, 0.08, 0.10)], np.float32)
    image = np.where(dots[..., None], palette[0], ground)
    for layer in (rings, border):
        inside = np.where((teeth & (layer == 2))[..., None], palette[0], palette[np.maximum(layer, 0)])
        image = over(image, layer >= 0, inside)
    return np.asarray(image * (0.92 + 0.10 * fractal(*y.shape, seed + 1, 0.1)[..., None]))


FLOOR = (-2.7, -3.7, 1.9, -1.1)  # x0, z0, x1, z1 in metres
RUG = (-0.75, -3.62, 1.75, -1.5)
WINDOW_LEFT, WINDOW_RIGHT, WINDOW_BOTTOM, WINDOW_TOP, WINDOW_Z = -0.35, 2.25, 0.85, 2.35, -4.2
TEXEL_M = 0.003
ELEVATION, AZIMUTH = np.radians(36), np.radians(38)  # of the sun, azimuth from -z towards +x
TOWARDS_SUN = np.array([np.cos(ELEVATION) * np.sin(AZIMUTH), np.sin(ELEVATION), -np.cos(ELEVATION) * np.cos(AZIMUTH)])
GAIN = 1.7  # how much brighter the sun makes a place than the room's own light


def sun_floor(boards: Image, shaded: NDArray[np.bool_]) -> Image:
    """Return (h, w, 3) sRGB, to be drawn 1 + GAIN times as bright as baked.

    boards: 2 m by 2 m. shaded: (h, w), where things in the room intercept the sun.
    """
    from scipy.ndimage import gaussian_filter

    x0, z0, x1, z1 = FLOOR
    height, width = shaded.shape
    x = (x0 + (np.arange(width, dtype=np.float32) + 0.5) * (x1 - x0) / width)[None]
    z = (z0 + (np.arange(height, dtype=np.float32) + 0.5) * (z1 - z0) / height)[:, None]
    # Picture rows run down and v runs along -z, so rows run along +z.
    column, row = ((x / 2) % 1 * len(boards)).astype(int), ((z / 2) % 1 * len(boards)).astype(int)
    image = boards[row, column]
    left, right = (round((edge - x0) / TEXEL_M) for edge in RUG[::2])
    top, bottom = (round((edge - z0) / TEXEL_M) for edge in RUG[1::2])
    down, across = np.meshgrid(
        np.linspace(0, 1, bottom - top, dtype=np.float32),
        np.linspace(0, 1, right - left, dtype=np.float32),
        indexing="ij",
    )
    image[top:bottom, left:right] = (np.clip(rug(down, across), 0, 1) * 255).astype(np.uint8)
    # Half a degree of sun blurs a shadow by two texels over 1.5 m.
    shadow = np.clip(gaussian_filter(shaded.astype(np.float32), 2.0) * 2.6, 0, 1)
    t = (WINDOW_Z - z) / TOWARDS_SUN[2]
    at_x, at_y = x + t * TOWARDS_SUN[0], t * TOWARDS_SUN[1] + 0 * x  # where the way to the sun meets the window's wall
    inside = (at_x > WINDOW_LEFT) & (at_x < WINDOW_RIGHT) & (at_y > WINDOW_BOTTOM) & (at_y < WINDOW_TOP)
    share = (1 + GAIN * inside.astype(np.float32) * (1 - shadow)) / (1 + GAIN)
    # sRGB is nearly a power of 2.2 over the range that matters.
    return np.asarray((image * (share ** (1 / 2.2))[..., None] + 0.5).astype(np.uint8))

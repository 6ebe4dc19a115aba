"""Pictures for the gallery, (h, w, 3) uint8: paintings, marble, the normals of an uneven floor."""

from __future__ import annotations

import numpy as np

from ._noise import Image, fractal, tinted, to_image

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
        image = np.where(
            land[..., None], third * (0.35 + 0.9 * (1 - y))[..., None] * (1 + 0.16 * rough)[..., None], image
        )
    elif kind == 1:
        flow = np.sin(9 * x + 3.5 * soft) * np.cos(7 * y + 2.5 * np.roll(soft, 60, axis=1))
        image = tinted(0.5 + 0.5 * flow, dark, bright)
        image = np.where((np.abs(flow) < 0.22)[..., None], third, image)
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
            image = np.where(
                (np.hypot(x - centre[0], (y - centre[1]) * height / width) < radius)[..., None], colour, image
            )
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
    return to_image(np.where((joint[:, None] | joint)[..., None], (0.24, 0.23, 0.22), image))


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

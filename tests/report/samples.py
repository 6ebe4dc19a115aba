"""A made-up run: rows, a summary, pictures; the numbers are only roughly like real ones."""

import numpy as np

from hmdwarp.metrics import QUALITY, aggregate, difference
from hmdwarp.report import WorstFrame, comparison_columns

from .bench_samples import a_run

FATES = ("drawn", "sent", "dropped", "lost", "undecodable", "late", "superseded", "shown", "under_way")
RESPONSE = {"render": 20.0, "encode": 7.2, "queue": 0.0, "transfer": 8.9, "round_trip": 200.0, "decode": 4.7}
RESPONSE |= {"warp": 31.5, "total": 272.3, "median": 268.4, "p95": 301.2}


def some_rows(seed: int = 0, seconds: float = 20, rate: float = 90, every: int = 10, worse: float = 1.0) -> list[dict]:
    rng = np.random.default_rng(seed)
    rows = []
    for frame in range(int(seconds * rate)):
        t = frame / rate
        turn = 90 * max(0, np.sin(1.3 * t)) ** 6 + 3 * rng.random()
        for eye in (0, 1):
            noise = 1 + 0.1 * rng.standard_normal()
            row = {
                "frame": frame, "eye": eye, "time_s": t, "shown_ns": int(t * 1e9),
                "drawn_ns": int(t * 1e9) - 200_000_000, "age_ms": 200.0, "pose_origin": "interpolated",
                "angular_speed_deg_s": turn, "linear_speed_m_s": 0.05 + turn / 600, "warp_ms": 9 * abs(noise),
                "fill_ms": 5 * abs(noise), "effects_ms": 0.0, "lens_ms": 7 * abs(noise), "total_ms": 21 * abs(noise),
            }  # fmt: skip
            if frame % every == 0:
                error = worse * (0.04 + turn / 900) * abs(noise)
                row |= {
                    "psnr_db": 34 - 90 * error, "ssim": 1 - error, "flip": error, "hole_share": turn / 700 * abs(noise),
                    "border_share": turn / 900 * abs(noise), "flicker": None if frame == 0 else error / 4,
                }  # fmt: skip
            rows.append(row)
    return rows


def a_summary(rows: list[dict] | None = None, warp: str = "forward") -> dict:
    rows = some_rows(seconds=2) if rows is None else rows
    return {
        **a_run(trace="look-around", latency_ms=200.0, warp=warp, fill="interpolate"),
        "predict": "cautious",
        "size": [640, 400],
        "frames": len(rows) // 2,
        **aggregate(rows),
        "regions": {
            "border_holes": {"share": 0.011, "psnr_db": 19.2, "flip": 0.31},
            "inside_holes": {"share": 0.034, "psnr_db": 21.4, "flip": 0.27},
            "silhouettes": {"share": 0.062, "psnr_db": 24.7, "flip": 0.16},
            "seen": {"share": 0.893, "psnr_db": 38.9, "flip": 0.03},
        },
        "filled": {"memory": 0.031, "pyramid": 0.02, "empty": 0.0},
        "link": {
            "frames": dict(zip(FATES, (120, 120, 0, 3, 0, 1, 2, 100, 14), strict=True)),
            "mbit_s": 21.4,
            "layers_mbit_s": {"inverse_depth": 12.1, "colour": 9.3},
            "frame_bytes": 44583.0,
            "codec": "h264",
            "encode_ms": 7.2,
            "decode_ms": 4.7,
            "coded_psnr_db": 38.1,
            "response_ms": {f"{name}_ms": value for name, value in RESPONSE.items()},
        },
    }


def a_baseline(rows: list[dict], its_rows: list[dict], warp: str = "none") -> dict:
    """The summary of the warp that the run with `rows` is compared with."""
    return {**a_summary(its_rows, warp), "difference": {name: difference(rows, its_rows, name) for name in QUALITY}}


def a_scene(shift: int = 0, size=(320, 200)) -> np.ndarray:
    """A picture with edges, gradients and fine texture."""
    y, x = np.mgrid[: size[1], : size[0]]
    x = x + shift
    board = (((x // 16) + (y // 16)) % 2 * 50 + 90 + 40 * np.sin(x / 30))[..., None]
    return np.clip(board * np.array([1.1, 0.9, 0.7]) + (y / 4)[..., None], 0, 255).astype(np.uint8)


def some_worst(count: int = 3, size=(320, 200)) -> list[WorstFrame]:
    frames = []
    for i in range(count):
        truth, rendered, warped = a_scene(0, size), a_scene(9 + 4 * i, size), a_scene(2, size)
        error = np.abs(warped.astype(int) - truth).max(axis=-1).astype(np.uint8)
        values = {"psnr_db": 20.1 + i, "ssim": 0.7, "flip": 0.2 - 0.02 * i, "hole_share": 0.031, "border_share": 0.02}
        columns = comparison_columns(rendered, truth, [("warped", warped, error), ("none", rendered, error)])
        frames.append(WorstFrame(3.2 * i + 1, i % 2, columns, values | {"flicker": None}))
    return frames


NAMES = (
    *("age_ms", "pose_age_ms", "period_ms", "busy_ms", "angular_speed_deg_s", "linear_speed_m_s"),
    *("hole_share/0", "hole_share/1"),
)
REFRESH = {"render": (3.0, 4.0), "warp": (2.5,), "fill": (1.0,), "effects": (0.0,), "lens": (1.0,), "total": (7.5,)}


def pair(median, p95=None):
    return {"median": median, "p95": median if p95 is None else p95}


def a_live_summary(**changes) -> dict:
    live = {
        "source": "openxr", "about": {"runtime": "Monado 25.0", "headset": "Simulated HMD"}, "record": "head.csv",
        "seconds": 12.5, "refreshes": 1001, "missed": 9, "waiting": 3, "unseen": 2, "over": 40, "timed": 1001,
        "age_ms": pair(203.4, 211.0), "pose_age_ms": pair(1.25, 1.9), "period_ms": pair(12.5, 13.1), "budget_ms": 12.5,
        "refresh_ms": {name: pair(*ms) for name, ms in REFRESH.items()},
        "changes": [{"time_s": 3.5, "frame": 280, "what": {"latency": [200.0, 250.0]}, "reason": "manual"}],
        "change_count": 1, "notices": {"tracking lost": 12}, "lost": [],
        "sampled_every": 1,
    }  # fmt: skip
    figures = aggregate(
        [{"warp_ms": 1.25, "fill_ms": 0.5, "effects_ms": 0.0, "lens_ms": 0.5, "total_ms": 2.25, "hole_share": 0.0213}]
    )
    return {
        **a_summary(), **figures, "clock": "gpu", "rate_hz": 80.0, "notes": ["A <note>."],
        "miss": {"stale_share": 9 / 1010, "longest_stale": 4, "budget_ms": 12.5},
        "live": {**live, **changes},
    }  # fmt: skip


def a_column(count=300, holes=True):
    rng = np.random.default_rng(1)
    columns = {"time_s": np.arange(count) / 80, **{name: rng.uniform(1, 12, count) for name in NAMES}}
    columns["pose_age_ms"][0] = columns["period_ms"][0] = np.nan
    if not holes:
        columns["hole_share/0"][:] = columns["hole_share/1"][:] = np.nan
    return lambda name: columns[name].copy()

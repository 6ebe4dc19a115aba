"""What every registry holds, as plain rows: for `hmdwarp list`, the README's tables and other programs."""

from __future__ import annotations

from collections.abc import Callable


def entries(kind: str) -> list[dict[str, str]]:
    """Rows of one kind, each with at least `name` and `summary`. kind: warps, fills, lenses, scenes, headsets, formats, recordings."""
    return _MAKERS[kind]()


def _warps() -> list[dict[str, str]]:
    from .client.warps import warps

    return [
        {"name": w.name, "summary": w.summary, "kind": w.kind, "exact_when": w.exact_when, "gets_wrong": w.gets_wrong, "source": w.source}
        for w in warps
    ]


def _fills() -> list[dict[str, str]]:
    from .client.fills import fills

    return [{"name": f.name, "summary": f.summary, "source": f.source} for f in fills]


def _lenses() -> list[dict[str, str]]:
    from .client.lens import lenses

    return [{"name": x.name, "summary": x.summary, "source": x.source} for x in lenses]


def _scenes() -> list[dict[str, str]]:
    from .scenes import scenes

    return [{"name": s.name, "summary": s.summary, "effects": " ".join(e.name for e in s.effects) or "none"} for s in scenes]


def _headsets() -> list[dict[str, str]]:
    from .headsets import headset_names, load_headset

    found = [load_headset(name) for name in headset_names()]
    return [{"name": h.name, "summary": h.summary, "source": h.source} for h in found]


def _formats() -> list[dict[str, str]]:
    from .poses.formats import FORMATS

    return [{"name": f.name, "summary": f.summary} for f in FORMATS]


def _recordings() -> list[dict[str, str]]:
    from .poses import load_trace
    from .resources import recording_names

    tracks = [load_trace(name).track for name in recording_names()]
    return [{"name": t.name, "summary": f"{t.duration_ns * 1e-9:.1f} s at {t.rate_hz:.0f} Hz: {t.origin}"} for t in tracks]


_MAKERS: dict[str, Callable[[], list[dict[str, str]]]] = {
    "warps": _warps,
    "fills": _fills,
    "lenses": _lenses,
    "scenes": _scenes,
    "headsets": _headsets,
    "formats": _formats,
    "recordings": _recordings,
}

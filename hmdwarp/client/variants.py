"""Warps and fills with settings as text: `mesh:cut=slope`, `memory+model:share=0.1`."""

from __future__ import annotations

from typing import TypeVar

from ..base import Choice, InputError, Registry, parse_choice
from ..frames import Needs
from ..scenes import CONVERGED, IndirectLight, lights
from .fills import Fill, fills
from .warps import Warp, warps

Entry = TypeVar("Entry", bound=Warp | Fill)


def parse_warp(text: str) -> Choice[Warp]:
    """Parse 'name' or 'name:key=value,key=value'.

    Errors: UnknownNameError for the name; InputError for a setting that it lacks, or a bad value.
    """
    return parse_choice(warps, text)


def parse_fills(text: str) -> tuple[Choice[Fill], ...]:
    """Parse 'memory+pyramid': a chain of fills, each written like a warp; () for 'none'.

    Errors: as parse_warp; InputError for 'none' in a chain, and for the same fill twice.
    """
    chain = tuple(parse_choice(fills, part.strip()) for part in text.split("+"))
    if len(chain) > 1 and not all(choice.entry.is_pass for choice in chain):
        raise InputError(f"fill '{text}': 'none' in a chain means nothing; leave it out")
    names = [choice.entry.name for choice in chain]
    if len(set(names)) < len(names):
        raise InputError(f"fill '{text}': the same fill twice; each takes all it can at its first turn")
    return tuple(choice for choice in chain if choice.entry.is_pass)


def parse_indirect(text: str) -> Choice[IndirectLight] | None:
    """Parse how the server finds indirect light: 'converged' (None), or 'name:key=value'.

    Errors: as parse_warp.
    """
    return None if text == CONVERGED else parse_choice(lights, text)


def lit_by(indirect: str) -> Needs:
    """Return what frames must carry for indirect light by that name; errors: as parse_warp."""
    light = parse_indirect(indirect)
    return Needs(**{light.entry.layer: light.settings}) if light is not None and light.entry.layer else Needs()


def fill_text(chain: tuple[Choice[Fill], ...]) -> str:
    """Return the shortest text equivalent to the chain."""
    return "+".join(map(str, chain)) or "none"


def every_warp() -> list[str]:
    """Return all registered warps, each followed by its variants for comparison."""
    return _every(warps)


def every_baseline() -> dict[str, str]:
    """Return the warps that do what a published or shipped system does, and which one."""
    return {
        str(parse_warp(f"{entry.name}:{settings}")): system
        for entry in warps
        for settings, system in entry.baselines.items()
    }


def every_fill() -> list[str]:
    """Return all registered fills, each followed by its variants for comparison."""
    return _every(fills)


def _every(registry: Registry[type[Entry]]) -> list[str]:
    texts = []
    for entry in registry:
        texts += [entry.name, *(f"{entry.name}:{variant}" for variant in entry.variants)]
    return texts

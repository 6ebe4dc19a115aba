"""Repairs: one file each, registered by name; each mends depth as cameras give it, before a warp.

A camera leaves pixels without depth, mixes near and far at silhouettes, and may hold its depth a
few pixels off its colour.
"""

from __future__ import annotations

from ...errors import InputError
from ...options import parse_choice
from ...registry import Registry
from ._base import MeasuredDepth, Pixels, Repair, RepairChain

repairs: Registry[type[Repair]] = Registry("repair", __name__)


def parse_repairs(text: str) -> RepairChain:
    """Parse 'edges+complete': a chain of repairs, each 'name' or 'name:key=value,key=value'.

    Errors: UnknownNameError for a name; InputError for a bad setting, for 'none' in a chain, and
    for what is no text.
    """
    if not isinstance(text, str):
        raise InputError(f"repair is {text!r}: expected a name: {', '.join(repairs.names())}, or several with +")
    chain = tuple(parse_choice(repairs, part.strip()) for part in text.split("+"))
    if len(chain) > 1 and not all(choice.entry.is_pass for choice in chain):
        raise InputError(f"repair '{text}': 'none' in a chain means nothing; leave it out")
    chain = tuple(choice for choice in chain if choice.entry.is_pass)
    return RepairChain(tuple(choice.entry(choice.settings) for choice in chain), "+".join(map(str, chain)) or "none")


__all__ = ["MeasuredDepth", "Pixels", "Repair", "RepairChain", "parse_repairs", "repairs"]

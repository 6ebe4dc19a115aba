"""Delay models of the network: one file each."""

from __future__ import annotations

from ...registry import Registry
from ._base import LONGEST_MS, DelayModel, milliseconds

delay_models: Registry[type[DelayModel]] = Registry("delay model", __name__)

__all__ = ["delay_models", "LONGEST_MS", "DelayModel", "milliseconds"]

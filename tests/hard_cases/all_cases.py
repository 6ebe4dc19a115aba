"""Imports every module of cases, so that each is filed."""

from . import depths, images, motions  # noqa: F401

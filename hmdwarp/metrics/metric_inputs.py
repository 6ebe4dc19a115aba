"""Inputs that metrics may be computed from."""

import enum


class Input(enum.Flag):
    """What a metric is computed from."""

    TRUTH = enum.auto()  # the picture without latency
    COVERAGE = enum.auto()  # which pixels the warp covered, before the fill
    DEPTH = enum.auto()  # inverse depth of the truth
    RENDERED = enum.auto()  # the view the late frame was rendered for
    PREVIOUS = enum.auto()  # the neighbouring frame of the same eye

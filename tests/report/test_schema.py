"""The contract of summary.json: what it takes, and that every single fault is told."""

import copy
import math

import pytest

from hmdwarp.base import InputError
from hmdwarp.metrics import aggregate, metrics
from hmdwarp.report import FRAME_COLUMNS, SUMMARY_KEYS, summary_faults, validate_summary

from .samples import a_live_summary, a_summary


def test_a_full_summary_and_one_without_any_measurement_are_fine():
    validate_summary(a_summary())
    validate_summary(a_live_summary())
    validate_summary({**a_summary(), **aggregate([]), "more": "keys are allowed"})


@pytest.mark.parametrize("key", SUMMARY_KEYS)
def test_every_key_is_needed(key):
    summary = a_summary()
    del summary[key]
    with pytest.raises(InputError, match=f"'{key}' is missing"):
        validate_summary(summary)


GL = {"gl_renderer": "a", "gl_version": "b"}
BAD = {
    "schema": (2, True, "1"), "hmdwarp": ("",), "trace": (None,), "effects": ("none", [1]),
    "latency_ms": (-1, math.nan, "200", 10**400), "size": ([640], [0, 4], (640, 400.0), [10**7, 4]),
    "frames": (-1, 1.5), "machine": ({}, {**GL, "cpu_count": 0}), "guard": ([], 0.5, "x", "0.9x1.5", "1.5"),
    "rate_hz": ({}, 0), "predict": ([1],), "clock": ("sun", []), "time_ms": ([], {}), "quality": ({"psnr_db": 3},),
}  # fmt: skip


@pytest.mark.parametrize(("key", "value"), [(key, value) for key, values in BAD.items() for value in values])
def test_every_bad_value_is_named_by_its_key(key, value):
    faults = summary_faults({**a_summary(), key: value})
    assert faults and all(f"'{key}" in fault for fault in faults)


@pytest.mark.parametrize("table, name, figure", [("quality", "flip", "p95"), ("time_ms", "warp", "median")])
@pytest.mark.parametrize("value", [math.nan, math.inf, 10**400, "3", True])
def test_figures_are_numbers_or_null(table, name, figure, value):
    summary = copy.deepcopy(a_summary())
    summary[table][name][figure] = value
    assert [f"'{table}.{name}.{figure}'" in fault for fault in summary_faults(summary)] == [True]


def test_all_faults_are_named_at_once():
    summary = {**a_summary(), "clock": "sun", "frames": -1}
    del summary["warp"]
    assert len(summary_faults(summary)) == 3
    assert all(summary_faults(thing) for thing in (None, [], "text", 3))


def test_columns_are_those_of_the_contract():
    names = "frame eye time_s shown_ns drawn_ns age_ms pose_age_ms pose_origin angular_speed_deg_s linear_speed_m_s"
    names += " warp_ms fill_ms effects_ms lens_ms total_ms "
    names += " ".join(metric.name for metric in sorted(metrics, key=lambda metric: metric.order))
    names += " shown_x_m shown_y_m shown_z_m shown_qx shown_qy shown_qz shown_qw drawn_origin"
    names += " drawn_x_m drawn_y_m drawn_z_m drawn_qx drawn_qy drawn_qz drawn_qw warp fill"
    assert tuple(names.split()) == FRAME_COLUMNS

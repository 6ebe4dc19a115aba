"""What a trace reader assumed is an entry of the loaded trace, with who says so."""

from __future__ import annotations

import json

import pytest

from hmdwarp.poses import TraceOptions, load_trace
from hmdwarp.poses.assumptions import Assumption, By, assumption_rows, first_stated

from .test_trace_command import run
from .traces import head, rows, write

TRACK = head(100)


def by(loaded) -> dict[str, By]:
    """Who says each fact."""
    return {assumption.what: assumption.by for assumption in loaded.assumptions}


def test_facts_of_a_plain_header_are_said_by_the_file_or_by_nobody(tmp_path):
    loaded = load_trace(write(tmp_path / "a.csv", rows(TRACK), "time,x,y,z,qx,qy,qz,qw"))
    assert by(loaded) == {
        "columns": By.FILE,
        "quaternion": By.FILE,
        "pose": By.NOBODY,
        "length": By.NOBODY,
        "axes": By.NOBODY,
        "up": By.NOBODY,
        "clock": By.NOBODY,
    }


def test_facts_that_the_user_states_are_the_users(tmp_path):
    path = write(tmp_path / "a.csv", rows(TRACK), "a,b,c,d,e,f,g,h")
    stated = TraceOptions(columns="t=a,p=b+c+d,q=e+f+g+h", axes="openxr", scale=1.0, time_unit="s")
    assert {what for what, who in by(load_trace(path, stated)).items() if who is not By.USER} == {"pose"}


def test_trace_info_prints_nobody_with_the_option(tmp_path):
    path = write(tmp_path / "a.csv", rows(TRACK), "time,x,y,z,qx,qy,qz,qw")
    text = run("info", path)
    assert "nobody says so; --axes states it" in text
    data = json.loads(run("info", path, "--json"))
    assert {"what": "clock", "value": "seconds", "by": "nobody", "option": "--time-unit"} in data["assumptions"]


@pytest.mark.parametrize(
    ("who", "said"),
    [(By.NOBODY, "nobody says so; --scale states it"), (By.FILE, "by the file"), (By.USER, "by the user")],
)
def test_an_assumption_says_who_says_it(who, said):
    one = Assumption("length", "1 m per unit", who, "--scale")
    assert str(one) == f"length: 1 m per unit ({said})"
    assert assumption_rows([one]) == [{"what": "length", "value": "1 m per unit", "by": who.value, "option": "--scale"}]


def test_the_first_that_states_a_fact_is_believed():
    assert first_stated(None, 2.0, 3.0) == (2.0, By.FILE)
    assert first_stated(None, None, None) == (None, By.NOBODY)

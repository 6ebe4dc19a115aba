"""The BIDS tree.

Names and contents by the rules of the specification, poses as they were recorded, no date anywhere.
"""

import csv
import json

import attrs
import numpy as np
import pytest

from hmdwarp.poses import load_trace
from hmdwarp.scenes import INPUTS_HEADER, InputEvent, inputs_beside
from hmdwarp.study.design import Show, steps_of
from hmdwarp.study.export.write import CHANNELS, ExportOptions, Rates, TrackingSystem, export, motion_text
from hmdwarp.study.store import PERSON, Store

from .conftest import day, write_trace


@pytest.fixture
def tree(store, design, tmp_path):
    return export(store.contents(), design, tmp_path / "out").folder / "bids"


def files(tree):
    return sorted(path for path in tree.rglob("*") if path.is_file())


def table(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def loaded(path):
    return json.loads(path.read_text(encoding="utf-8"))


def test_a_validator_of_others_takes_every_name(tree):
    validator = pytest.importorskip(
        "bids_validator", reason="bids_validator is not installed (pip install bids_validator)"
    ).BIDSValidator()
    for path in files(tree):
        assert validator.is_bids(f"/{path.relative_to(tree).as_posix()}"), path


def test_every_column_of_every_table_is_in_its_sidecar(tree):
    for path in tree.rglob("*.tsv"):
        if path.name.endswith(("_motion.tsv", "_channels.tsv")):
            continue
        with path.open(encoding="utf-8") as file:
            columns = file.readline().rstrip("\n").split("\t")
        side = loaded(path.with_suffix(".json"))
        assert [name for name in columns if name != "participant_id" and "Description" not in side.get(name, {})] == []
        lines = path.read_text(encoding="utf-8").splitlines()
        assert all(line.count("\t") == len(columns) - 1 and "\t\t" not in line for line in lines)


def test_poses_are_as_they_were_recorded(tree, store):
    """Read by NumPy, against what the trace reader reads."""
    count = 0
    for session in store.contents().sessions:
        folder = tree / f"sub-{session.sub}" / "ses-01"
        scans = {row["filename"]: row for row in table(folder / f"sub-{session.sub}_ses-01_scans.tsv")}
        shown = {
            (showing.trial, showing.presentation): showing
            for showing in store.contents().showings
            if showing.session == session.id
        }
        for path in sorted(folder.glob("motion/*_motion.tsv")):
            row = scans[f"motion/{path.name}"]
            showing = shown[int(row["trial"]), int(row["presentation"])]
            assert row["condition"] == showing.condition
            track = load_trace(store.traces / showing.trace).track
            data = np.loadtxt(path, delimiter="\t")
            assert (data[:, 1:4] == track.position_m).all() and (data[:, 4:] == track.orientation_xyzw).all()
            # Instants are rounded to the microsecond, as the specification writes them.
            assert np.abs(data[:, 0] * 1e9 - (track.time_ns - track.start_ns)).max() <= 500.1 and data[0, 0] == 0
            channels = table(path.with_name(path.name.replace("_motion", "_channels")))
            assert len(channels) == data.shape[1] == len(CHANNELS)
            assert [channel["type"] for channel in channels] == ["LATENCY", *["POS"] * 3, *["ORNT"] * 4]
            assert [channel["component"] for channel in channels] == [
                "n/a", "x", "y", "z", "quat_x", "quat_y", "quat_z", "quat_w",
            ]  # fmt: skip
            count += 1
    assert count == 4 + 3 + 4


def test_rates_tell_how_uneven_samples_are(tmp_path):
    track = write_trace(tmp_path / "a.csv", 1, samples=400)
    steps = np.diff(track.time_ns)
    rates = Rates.of(track)
    assert rates.nominal_hz == pytest.approx(1e9 / np.median(steps)) and rates.effective_hz == pytest.approx(
        399e9 / steps.sum()
    )
    # Steps are even between 10.5 and 11.7 ms: one tenth of that range lies more than 0.555 ms from
    # its middle, half of it on either side.
    assert 0.02 < rates.uneven < 0.15
    even = track.evolve(time_ns=np.arange(400) * 11_111_111, max_gap_ns=10**9)
    assert Rates.of(even).uneven == 0 and "0.0%" in Rates.of(even).describe()
    assert motion_text(even).splitlines()[1].startswith("0.011111\t")


def test_no_date_and_no_code_is_in_any_byte(tree):
    """The tests' clock says 2031-07-23, 16:41; so do the traces' headers."""
    for path in tree.parent.rglob("*"):
        data = path.read_bytes() if path.is_file() else b""
        for word in (
            b"2031-0", b"16:41", b"16:42", b"Alpha-1", b"Beta-2", b"Gamma-3", b"Pilot-4", b"secret-of",
            b"Recorder of",
        ):  # fmt: skip
            assert word not in data and word.decode() not in path.name, (
                path.name,
                word,
                data[max(0, data.find(word) - 40) :][:80],
            )


HEADSET = {"runtime": "Monado", "runtime_version": "25.0.0", "headset": "Index"}
LED = [  # facts of a session; label, name, model
    ({"source": "desktop", "headset": "rift-dk1"}, ("mouse", "mouse and keyboard of a desktop window", "")),
    ({"source": "desktop", "headset": "rift-dk1", "trace": "secret.csv"}, ("trace", "head trace, replayed", "")),
    (
        {"source": "offscreen", "trace": "secret.csv", "trace_axes": "unity (..), assumed"},
        ("trace", "head trace, replayed; its axes: unity (..), assumed", ""),
    ),
    (
        {"source": "openxr", "headset": "Index", "display": HEADSET},
        ("hmd", "Index, by OpenXR runtime Monado 25.0.0", "Index"),
    ),
    ({"headset": "rift-dk1"}, ("unknown", "not recorded", "")),
]


@pytest.mark.parametrize(("facts", "wanted"), LED, ids=[wanted[1][:22] for _, wanted in LED])
def test_the_tracking_system_is_named_not_the_emulated_headset(facts, wanted):
    assert attrs.astuple(TrackingSystem.of(facts)) == wanted


def test_a_session_resumed_elsewhere_names_what_led_the_head_then(tmp_path, design):
    """Begun with a mouse and resumed in a headset: each trial's own."""
    with Store(tmp_path / "data", create=True, clock=day()) as store:
        session = store.begin(design, None, "P1", PERSON, facts={"source": "desktop", "headset": "rift-dk1"})
        steps = [step for step in steps_of(design, session.order, session.part) if isinstance(step, Show)]
        for step in steps[:2]:
            if step is steps[1]:
                store.end(session, "interrupted")
                store.resume("P1", facts={"source": "openxr", "display": HEADSET})
            showing = store.begin_showing(session, step, {})
            write_trace(store.traces / showing.trace, step.trial)
            store.end_showing(session, showing, {}, complete=True)
        contents = store.contents()
    tree = export(contents, design, tmp_path / "out").folder / "bids"
    sides = [loaded(path) for path in sorted(tree.rglob("*_motion.json"), key=lambda path: "tracksys-hmd" in path.name)]
    assert [side["TrackingSystemName"] for side in sides] == [LED[0][1][1], LED[3][1][1]]
    assert [side["ManufacturersModelName"] for side in sides] == ["n/a", "Index"]


def test_what_was_done_in_a_trial_is_events_of_its_recording(store, design, tmp_path):
    """By the recording's clock, oldest first; recordings without inputs have no such columns."""
    contents = store.contents()
    first, *others = [showing for showing in contents.showings if showing.trial == 1]
    start_ns = int((store.traces / first.trace).read_text("utf-8").split("time_ns")[1].split("\n")[1].split(",")[0])
    done = [
        InputEvent(start_ns + 300_000_000, "release", "ball", (0.5, 1.25, -1.0), (0.0, -0.5, -2.0)),
        InputEvent(start_ns + 12_345_678, "grab", "ball", (0.25, 1.5, -0.0), (0.0, 0.0, -1.0)),
    ]
    inputs_beside(store.traces / first.trace).write_text(INPUTS_HEADER + "".join(each.row for each in done))
    inputs_beside(store.traces / others[0].trace).write_text(INPUTS_HEADER + "soon,push,ball,0,0,0,0,0,-1\n")
    made = export(contents, design, tmp_path / "out")
    (left_out,) = [text for text in made.notes if text.startswith("left out: ")]
    assert others[0].trace in left_out and "line 2: 'soon," in left_out
    tables = {path: table(path) for path in made.folder.rglob("motion/*_events.tsv")}
    ((path, (trial, *rows)),) = [(path, rows) for path, rows in tables.items() if "action" in rows[0]]
    assert {name for name, value in trial.items() if value == "n/a"} == {"action", "target", *"xyz", "dx", "dy", "dz"}
    assert [(row["onset"], row["duration"], row["action"], row["target"]) for row in rows] == [
        ("0.012346", "0", "grab", "ball"),
        ("0.3", "0", "release", "ball"),
    ]
    numbers = [[float(row[name]) for name in ("x", "y", "z", "dx", "dy", "dz")] for row in rows]
    assert numbers == [[0.25, 1.5, 0, 0, 0, -1], [0.5, 1.25, -1, 0, -0.5, -2]]
    side = loaded(path.with_suffix(".json"))
    assert all("Description" in side[name] for name in rows[0]) and side["x"]["Units"] == "m"
    assert set(side["action"]["Levels"]) == {"push", "switch", "grab", "release"}
    test_every_column_of_every_table_is_in_its_sidecar(made.folder / "bids")


def test_without_motion_the_rest_is_the_same(store, design, tmp_path):
    whole = export(store.contents(), design, tmp_path / "whole").folder
    made = export(store.contents(), design, tmp_path / "out", ExportOptions(motion=False))
    assert not [*made.folder.rglob("*motion*")] and "without head motion" in made.notes[-1]
    for path in sorted(made.folder.rglob("*_beh.*")) + [made.folder / "ratings.csv"]:
        assert path.read_bytes() == (whole / path.relative_to(made.folder)).read_bytes()
    scans = [row for path in made.folder.rglob("*_scans.tsv") for row in table(path)]
    assert scans and all(row["filename"].startswith("beh/") for row in scans)


def test_an_unreadable_trace_is_reported_and_the_rest_exported(store, design, tmp_path):
    contents = store.contents()
    showings = [showing for showing in contents.showings if showing.trial == 1]
    (store.traces / showings[0].trace).write_text("no trace at all\n", encoding="utf-8")
    (store.traces / showings[1].trace).unlink()
    made = export(contents, design, tmp_path / "out")
    assert len([text for text in made.notes if text.startswith("left out: ")]) == 2
    assert len(list(made.folder.rglob("*_motion.tsv"))) == 11 - 2

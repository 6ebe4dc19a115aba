"""Whatever bytes a file holds, a reader gives a track or one clear error.

Never anything else, and it ends.
"""

from __future__ import annotations

import json
import string
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from properties import ONE_FIXTURE_FOR_ALL

from hmdwarp import resources
from hmdwarp.errors import InputError
from hmdwarp.poses import TraceOptions, analyse, load_trace
from hmdwarp.poses.formats import formats

from . import test_other_files as files
from .traces import head, rows

SETTINGS = settings(max_examples=150, suppress_health_check=ONE_FIXTURE_FOR_ALL)
TABLE = rows(head(30), "wxyz")
SMALL_FILES = [
    "\n".join(["timestamp,x,y,z,qw,qx,qy,qz"] + [",".join(r) for r in TABLE]) + "\n",
    "\n".join(["# timestamp tx ty tz qx qy qz qw"] + [" ".join(r) for r in TABLE]) + "\n",
    "\n".join(
        ["Device;Time;PosX;PosY;PosZ;QuatW;QuatX;QuatY;QuatZ"]
        + [";".join([str(i % 2), *r]).replace(".", ",") for i, r in enumerate(TABLE)]
    ),
    "\n".join(" ".join([r[0], str(i), *r[4:]]) for i, r in enumerate(TABLE)) + "\n",
    "\n".join(["timestamp viewpoint w x y z"] + [" ".join([r[0], "0", *r[4:]]) for r in TABLE]) + "\n",
    "\n".join(",".join([str(638 * 10**15 + i * 166667), *r[1:]]) for i, r in enumerate(TABLE)) + "\n",
]
EXPORTS = [
    files.VECTORS["Unity in quotes"],
    files.VECTORS["JSON in quotes"],
    json.dumps({"schema": [], "frames": files.iwer_frames(files.TRACK)}),
    json.dumps(files.JSON_FORMS["columns and data"]),
    "\n".join(files.motive()),
    "\n".join(files.qualisys()),
    "\n".join(files.unreal("rotator")),
]

options = st.builds(
    TraceOptions,
    format=st.sampled_from([None, *formats.names()]),
    quat_order=st.sampled_from([None, "xyzw", "wxyz"]),
    up=st.sampled_from([None, "z", "x,y,z", "0.1,1,0.2"]),
    scale=st.sampled_from([None, 0.01, 1e6]),
    rate=st.sampled_from([None, 90.0, 1e-3]),
    segment=st.sampled_from([None, 1, 2]),
)


def survives(path: Path, content: bytes, opts: TraceOptions) -> None:
    """A whole track that can be asked for anything, or an InputError of one line."""
    path.write_bytes(content)
    try:
        loaded = load_trace(path, opts)
    except InputError as error:
        assert "\n" not in str(error)
        assert str(error)
        return
    track = loaded.track
    assert len(track) >= 2
    assert track.start_ns == 0
    for t in (-1, 0, track.end_ns // 2, track.end_ns + 1):
        track.at(t)
    analyse(track, latencies_ms=(20,))


@SETTINGS
@given(st.binary(max_size=600), options)
def test_random_bytes(tmp_path, content, opts):
    survives(tmp_path / "f.csv", content, opts)


@SETTINGS
@given(st.text(alphabet="0123456789.,;-+eE \t\n#nanif:\"'xyzwqt/", max_size=400), options)
def test_random_text_of_numbers(tmp_path, content, opts):
    survives(tmp_path / "f.csv", content.encode(), opts)


fields = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True).map(repr),
    st.integers(-(10**25), 10**25).map(str),
    st.sampled_from(
        ["", "0", "1", "-0", "1e999", "1e-999", "nan", "12:34:56.7", "2020-01-01T00:00:00", "9" * 19, "0,5", "HMD"]
        + ['"1"', "0x1"]
    ),
    st.text(string.printable, max_size=5),
)
separators = st.sampled_from([",", ";", " ", "\t", ", "])
headers = st.sampled_from(
    [
        "",
        "time,x,y,z,qx,qy,qz,qw",
        "timestamp viewpoint w x y z",
        "t;qw;qx;qy;qz",
        "Device,time_ns,x_m,y_m,z_m,qx,qy,qz,qw",
        "timestamp,q0,q1,q2,q3",
    ]
)


@SETTINGS
@given(headers, separators, st.lists(st.lists(fields, min_size=4, max_size=9), max_size=8), options)
def test_random_tables(tmp_path, header, separator, table, opts):
    text = "\n".join([header, *(separator.join(r) for r in table)])
    survives(tmp_path / "f.csv", text.encode("utf-8", "surrogatepass"), opts)


@st.composite
def mutations(draw, contents: list[bytes]) -> bytes:
    """A file with a few pieces cut out, doubled, swapped or overwritten."""
    data = bytearray(draw(st.sampled_from(contents)))
    for _ in range(draw(st.integers(1, 4))):
        at, length = draw(st.integers(0, len(data))), draw(st.integers(0, 120))
        what = draw(st.sampled_from(["cut", "double", "move", "noise", "truncate", "digit"]))
        piece = bytes(data[at : at + length])
        if what == "cut":
            del data[at : at + length]
        elif what == "double":
            data[at:at] = piece
        elif what == "move":
            to = draw(st.integers(0, len(data)))
            del data[at : at + length]
            data[to:to] = piece
        elif what == "noise":
            data[at:at] = draw(st.binary(max_size=6))
        elif what == "digit":
            data[at : at + 1] = draw(st.sampled_from([b"9", b"-", b".", b",", b" ", b"\n", b"e", b"0"]))
        else:
            del data[at:]
    return bytes(data)


@SETTINGS
@given(data=st.data(), opts=st.one_of(st.just(TraceOptions()), options))
def test_mutated_files_of_every_layout(tmp_path, data, opts):
    survives(tmp_path / "f.csv", data.draw(mutations([f.encode() for f in SMALL_FILES])), opts)


@settings(SETTINGS, max_examples=60)
@given(data=st.data(), opts=st.one_of(st.just(TraceOptions()), options))
def test_mutated_exports(tmp_path, data, opts):
    survives(tmp_path / "f.csv", data.draw(mutations([f.encode() for f in EXPORTS])), opts)


@settings(SETTINGS, max_examples=60)
@given(data=st.data(), opts=st.one_of(st.just(TraceOptions()), options))
def test_mutated_recordings(tmp_path, data, opts):
    files = [
        (resources.folder("recordings") / f"{name}.csv").read_bytes()[:40_000] for name in resources.recording_names()
    ]
    survives(tmp_path / "f.csv", data.draw(mutations(files)), opts)


@settings(SETTINGS, max_examples=60)
@given(data=st.data(), opts=st.one_of(st.just(TraceOptions()), options))
def test_mutated_real_files(tmp_path, real_traces, data, opts):
    files = [p.read_bytes()[:30_000] for p in sorted(real_traces.glob("*/*")) if p.suffix in (".csv", ".txt")]
    survives(tmp_path / "f.csv", data.draw(mutations(files)), opts)


@pytest.mark.parametrize("size", [*range(0, 900, 37), 4000])
def test_a_recording_cut_off_anywhere(tmp_path, size):
    survives(tmp_path / "f.csv", (resources.folder("recordings") / "walk.csv").read_bytes()[:size], TraceOptions())

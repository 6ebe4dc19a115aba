"""JSON and TOML: whatever the text, what it holds or one line, at once and in little memory."""

from __future__ import annotations

import os
import random
import re
from collections.abc import Callable
from pathlib import Path

import attrs
import pytest
from published_folders import PUBLISHED
from recorded_folders import LAYOUTS, taken

import hmdwarp
from hmdwarp.client.classes import load_client
from hmdwarp.errors import InputError
from hmdwarp.headsets import load_headset
from hmdwarp.options.documents import MOST_DEPTH, DocumentError, parse_json, parse_toml
from hmdwarp.pipeline.governor import read_rows
from hmdwarp.poses import load_trace
from hmdwarp.scenes import load_scene
from hmdwarp.sources import sequences
from hmdwarp.sources.sequences import read_view
from hmdwarp.study.analysis.findings import load_claims
from hmdwarp.study.design import load_design
from hmdwarp.study.respondents import load_model
from hmdwarp.study.scales import load_scale

PACKAGE = Path(hmdwarp.__file__).parent
HUGE = 200_000

JSON = {
    "lists in each other": "[" * HUGE,
    "lists that end": "[" * HUGE + "]" * HUGE,
    "objects in each other": '{"a":' * HUGE,
    "one more than allowed": "[" * (MOST_DEPTH + 1) + "]" * (MOST_DEPTH + 1),
    "a long key": '{"' + "k" * HUGE + '": 1}',
    "a key twice": '{"a": 1, "b": {"c": 1, "c": 2}}',
    "half a character": r'{"a": "\ud800"}',
    "UTF-16": '{"a": 1}'.encode("utf-16"),
    "Latin-1": '{"a": "é"}'.encode("latin-1"),
    "nothing": "",
}
TOML = {  # tomllib alone takes minutes for a dotted key
    "lists in each other": "a = " + "[" * HUGE,
    "lists that end": "a = " + "[" * 500 + "]" * 500,
    "tables in each other": "a = " + "{a = " * HUGE,
    "a dotted key": ".".join("a" * HUGE) + " = 1",
    "a dotted key with blanks": " . ".join(['"a"'] * HUGE) + " = 1",
    "a dotted heading": "[" + ".".join("a" * HUGE) + "]",
    "a long key": "k" * HUGE + " = 1",
    "a key twice": "a = 1\na = 2",
    "a number of many digits": "a = " + "1" * HUGE,
}


def refusal_of(parse: Callable[[str | bytes], object], text: str | bytes) -> str:
    with pytest.raises(DocumentError) as caught:
        parse(text)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 300
    return str(caught.value)


@pytest.mark.parametrize("what", JSON)
def test_json_that_is_refused(what):
    refusal_of(parse_json, JSON[what])


@pytest.mark.parametrize("what", TOML)
def test_toml_that_is_refused(what):
    refusal_of(parse_toml, TOML[what])


def test_json_keeps_what_it_holds():
    deep = "[" * MOST_DEPTH + "]" * MOST_DEPTH
    assert parse_json(deep) == eval(deep)
    assert parse_json('\ufeff{"a": [1, -9223372036854775808, 1.5, true, null], "\\ud83d\\ude00": ""}'.encode()) == {
        "a": [1, -(2**63), 1.5, True, None],
        "\U0001f600": "",
    }


def test_whole_numbers_of_json_fit_a_float():
    assert parse_json(f"[{10**30}, -{10**400}, {'9' * HUGE}]") == [1e30, float("-inf"), float("inf")]


# --- readers, on mutations of what they read

SPOILT = [b"[", b"]", b"{", b"}", b'"', b",", b"=", b"-1", b"1e999", b"NaN", b"null", b"[]", b"{}", b"0", b"1" * 400]
SPOILT += [b"true", b'"a"', b"\xff", b"\0", b"\xef\xbb\xbf", b'"\\ud800"', b"Infinity", b"\n", b"3.5", b"9" * 5000]


def mutated(data: bytes, rng: random.Random) -> bytes:
    for _ in range(rng.choice((1, 1, 1, 2, 5))):
        at, length = rng.randrange(len(data)), rng.choice((0, 1, 1, 3, 10, 40))
        kind = rng.randrange(4)
        if kind == 0:
            data = data[:at] + rng.choice(SPOILT) + data[at + length :]
        elif kind == 1:
            data = data[:at] + data[at + length :]
        elif kind == 2:
            other = rng.randrange(len(data))
            data = data[:at] + data[other : other + length] + data[at:]
        else:
            values = [match.span() for match in re.finditer(rb'-?\d[\d.eE+-]*|"[^"\n]*"|\b[a-z]+\b', data)]
            begin, end = rng.choice(values) if values else (at, at)
            data = data[:begin] + rng.choice(SPOILT) + data[end:]
        data = data or b" "
    return data


def folder_of(form: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        (LAYOUTS[form][1] if form in LAYOUTS else PUBLISHED[form].write)(folder, taken(2))
        return next(iter(sorted(folder.glob("*.json"))))

    return write


def read_folder(form: str) -> Callable[[Path], object]:
    reader, _, options = LAYOUTS[form] if form in LAYOUTS else (form, None, PUBLISHED[form].options)

    def read(path: Path) -> object:
        opened = sequences.open(path.parent, attrs.evolve(options, layout=reader))
        return [frame.read() for frame in opened.frames[:1]]

    return read


def copy_of(path: str, name: str = "mine.toml") -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        (folder / name).write_bytes((PACKAGE / path).read_bytes())
        return folder / name

    return write


def text_of(name: str, text: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        (folder / name).write_text(text)
        return folder / name

    return write


POSE = '{"position_m": [0, 1.6, 0], "orientation_xyzw": [0, 0, 0, 1], "fov": [-0.7, 0.7, -0.6, 0.6]}'
RECORDS = ",".join(f'{{"t": {n / 90}, "position": [0, {n / 100}, 0], "rotation": [0, 0, 0, 1]}}' for n in range(9))
IWER = ",".join(f"[{n * 11}, 0, 1.6, {n / 50}, 0, 0, 0, 1, []]" for n in range(9))
GLTF = """{"asset": {"version": "2.0"}, "buffers": [{"uri": "data:;base64,%s", "byteLength": 36}],
"bufferViews": [{"buffer": 0, "byteLength": 36}], "scene": 0, "scenes": [{"nodes": [0]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
"materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}, "alphaMode": "OPAQUE"}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0, "mode": 4}]}],
"nodes": [{"mesh": 0, "translation": [0, 0, -2], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}]}
""" % ("AAAA" * 3 + "AACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA")
READERS: dict[str, tuple[Callable[[Path], Path], Callable[[Path], object]]] = {
    **{form: (folder_of(form), read_folder(form)) for form in ("nerfstudio", "pictures", "redwood", "open3d")},
    "view": (text_of("pose.json", POSE), read_view),
    "records": (text_of("head.json", f"[{RECORDS}]"), load_trace),
    "iwer": (text_of("head.json", f'{{"schema": [["head", {{}}]], "frames": [{IWER}]}}'), load_trace),
    "gltf": (text_of("scene.gltf", GLTF), load_scene),
    "bench": (text_of("bench.json", '{"schema": 1, "rows": [{"warp": "forward", "time_ms": {}}]}'), read_rows),
    "headset": (copy_of("headsets/rift-dk1.toml"), lambda path: load_headset(str(path))),
    "client": (copy_of("client/classes/class-2.toml"), lambda path: load_client(str(path))),
    "scale": (copy_of("study/scales/ssq.toml"), lambda path: load_scale(str(path))),
    "study": (copy_of("study/ready/thesis.toml"), lambda path: load_design(str(path), checked=False)),
    "respondents": (copy_of("study/respondents/thesis.toml"), lambda path: load_model(str(path))),
    "claims": (copy_of("study/ready/thesis_claims.toml"), load_claims),
}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kind", READERS)
def test_a_reader_says_in_one_line_what_is_wrong_with_a_mutation(kind, tmp_path):
    write, read = READERS[kind]
    path = write(tmp_path)
    data, rng, refused = path.read_bytes(), random.Random(kind), 0
    for number in range(int(os.environ.get("HMDWARP_MUTATIONS", "25"))):
        path.write_bytes(spoilt := mutated(data, rng))
        try:
            read(path)
        except InputError as error:
            refused += 1
            assert "\n" not in str(error) and len(str(error)) < 2000, (number, str(error))
        except Exception as error:
            raise AssertionError(f"mutation {number} of {kind}: {spoilt[-3000:]!r}") from error
    assert refused > 0

"""Every reader against damaged files: each is read or refused in one line, within limits.

Each case is a valid file or folder, damaged inside its container (lengths and checksums are put
right, so that the damage gets past them), and read in a process of its own with limits.

    .venv/bin/python tests/fuzz.py --seconds 600 --seed 7
    .venv/bin/python tests/fuzz.py --again out/fuzz/FINDING          one finding, with its traceback
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import importlib.util
import io
import json
import os
import random
import re
import resource
import shutil
import signal
import struct
import sys
import tempfile
import time
import traceback
import warnings
import zipfile
import zlib
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import attrs
import numpy as np

MOST_MIB, MOST_CPU_S, MOST_WALL_S = 1024, 20, 900
os.environ["ARROW_DEFAULT_MEMORY_POOL"] = "system"  # its own reserves a GiB of addresses, which is all there may be
READ, REFUSED, FAULT = 0, 2, 1
IN = "taken"  # some layouts have a file beside their folder
HERE = Path(__file__).resolve()
ROOT = HERE.parents[1]


# Damage


NUMBERS = [b"0", b"-1", b"1e999", b"-1e308", b"1e-320", b"nan", b"inf", b"9" * 25, b"4294967296", b"65536", b"1e5"]
WORDS = [b"", b'""', b"null", b"true", b"[]", b"{}", b"\xff\xfe", b"\0", b"'", b"x" * 3000, b"=", b"\n\n", b"[[", b"1"]
WORDS += [b"[" * 2000 + b"]" * 2000, b'{"a":' * 2000 + b"1" + b"}" * 2000, b"a." * 2000 + b"a = 1", b"(" * 2000]
VALUES = [None, True, 0, -1, 2, 65536, 2**31, 2**64, 10**30, 0.5, 1e308, 1e-320, float("nan"), float("inf"), "", "x"]
VALUES += ["../x", "\0", "x" * 300, [], {}, [0], [[]], {"a": 1}, [1e308] * 3, ["x"] * 16]
WHOLES = [0, 1, 2, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 2**24, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**64 - 1]
FLOATS = [float("nan"), float("inf"), -1e300, 1e300, 1e-320, 0.0]
TOKEN = re.compile(rb"[-+]?\d[\d.eE+-]*|[A-Za-z_]\w*|\"[^\"\n]*\"|[^\s\w]")


def damaged_bytes(data: bytes, rng: random.Random) -> bytes:
    """Return the data with a piece cut out, doubled, moved, overwritten or replaced by a number."""
    at, length = rng.randrange(len(data) + 1), rng.choice([1, 1, 2, 4, 8, rng.randrange(120)])
    before, piece, after = data[:at], data[at : at + length], data[at + length :]
    way = rng.randrange(8)
    if way == 0:
        to = rng.randrange(len(before + after) + 1)
        return (before + after)[:to] + piece + (before + after)[to:]
    if way < 3:
        return before + piece * rng.choice([0, 2, 51]) + after
    if way == 3:
        return before
    new = rng.randbytes(length)
    if way == 5:
        new = bytes(byte ^ 1 << rng.randrange(8) for byte in piece[:1])
    elif way == 6:
        width = rng.choice("BHIQ")
        new = struct.pack(rng.choice("<>") + width, rng.choice(WHOLES) % 256 ** struct.calcsize(width))
    elif way == 7:
        with np.errstate(over="ignore"):
            new = np.array(rng.choice(FLOATS)).astype(rng.choice(["<f4", "<f8"])).tobytes()
    return before + new + data[at + len(new) :]


def damaged_text(data: bytes, rng: random.Random) -> bytes:
    """Return the data with one of its numbers, words or signs replaced, or a line moved."""
    found = list(TOKEN.finditer(data[:200_000]))
    if not found or rng.random() < 0.2:
        lines = data.split(b"\n")
        one, other = rng.randrange(len(lines)), rng.randrange(len(lines))
        lines[one : one + rng.choice([0, 1, 1, 3])] = [lines[other]] * rng.choice([0, 1, 1, 20])
        return b"\n".join(lines)
    token = rng.choice(found)
    other = rng.choice(found).group()
    return data[: token.start()] + rng.choice([*NUMBERS, *WORDS, *[other] * 6]) + data[token.end() :]


def made_up(rng: random.Random) -> bytes:
    """Return a table of anything, or random bytes."""
    if rng.random() < 0.2:
        return rng.randbytes(rng.randrange(600))
    heads = b"time,x,y,z,qx,qy,qz,qw|timestamp viewpoint w x y z|t;qw;qx;qy;qz|Device,time_ns,x|".split(b"|")
    fields = [*NUMBERS, *WORDS[:6], *b'12:34:56.7 2020-01-01T00:00:00 0,5 HMD "1" 0x1 1 2 3'.split()]
    sign = rng.choice([b",", b";", b" ", b"\t", b", "])
    rows = [sign.join(rng.choices(fields, k=rng.randrange(4, 9))) for _ in range(rng.randrange(8))]
    return b"\n".join([rng.choice(heads), *rows])


def damaged_json(data: bytes, rng: random.Random) -> bytes:
    """Return the JSON with a value anywhere in it replaced, left out, or named otherwise."""
    root = [json.loads(data)]
    places: list[tuple[Any, Any]] = []

    def walk(value: Any) -> None:
        for key in list(value) if isinstance(value, dict) else range(len(value)):
            places.append((value, key))
            if isinstance(value[key], dict | list):
                walk(value[key])

    walk(root)
    inside, key = rng.choice(places)
    way, value = rng.randrange(6), inside[key]
    if way == 0 and inside is not root:
        del inside[key]
    elif way == 1 and isinstance(inside, dict):
        inside[rng.choice(["", "x", str(key).upper()])] = inside.pop(key)
    elif way == 2:
        there, other = rng.choice(places)
        inside[key] = json.loads(json.dumps(there[other]))
    elif way == 3 and type(value) in (int, float):
        inside[key] = value * rng.choice([-1, 1.5, 2**16, 10**12])
    else:
        inside[key] = rng.choice(VALUES)
    return json.dumps(root[0]).encode()


def damaged_zip(data: bytes, rng: random.Random) -> bytes:
    """Return the archive with one member damaged, gone, or under another name."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    name, out, way = rng.choice(list(members)), io.BytesIO(), rng.randrange(8)
    member = members.pop(name)
    if way:
        members[rng.choice(["x.npy", *members]) if way == 1 and members else name] = damaged(member, rng)
    with zipfile.ZipFile(out, "w", rng.choice([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])) as archive:
        for name, member in members.items():
            archive.writestr(name, member)
    return out.getvalue()


def damaged_png(data: bytes, rng: random.Random) -> bytes:
    """Return the picture with a chunk damaged, moved or gone; checksums fit."""
    chunks, at = [], 8
    while at + 12 <= len(data):
        length = int.from_bytes(data[at : at + 4], "big")
        chunks.append([data[at + 4 : at + 8], data[at + 8 : at + 8 + length]])
        at += 12 + length
    one, way = rng.choice(chunks), rng.randrange(6)
    if way == 0:
        chunks.remove(one)
    elif way == 1:
        chunks.insert(rng.randrange(len(chunks)), one)
    elif way == 2 and one[0] == b"IDAT":
        one[1] = zlib.compress(damaged_bytes(zlib.decompress(one[1]), rng))
    else:
        one[1] = damaged_bytes(one[1], rng)
    return data[:8] + b"".join(
        struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body)) for name, body in chunks
    )


def damaged_glb(data: bytes, rng: random.Random) -> bytes:
    """Return the scene with a value of its JSON, or its binary chunk, damaged; lengths fit."""
    length = int.from_bytes(data[12:16], "little")
    header, binary = data[20 : 20 + length], data[28 + length :]
    if rng.random() < 0.75 or not binary:
        header = damaged_json(header, rng)
    else:
        binary = damaged_bytes(binary, rng)
    parts = [(b"JSON", header + b" " * (-len(header) % 4)), (b"BIN\0", binary + b"\0" * (-len(binary) % 4))]
    body = b"".join(struct.pack("<I", len(part)) + kind + part for kind, part in parts)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


STRUCTURED: list[tuple[bytes, Callable[[bytes, random.Random], bytes]]] = [
    (b"PK\x03\x04", damaged_zip),
    (b"\x89PNG", damaged_png),
    (b"glTF", damaged_glb),
    (b"{", damaged_json),
    (b"[{", damaged_json),
]


def damaged(data: bytes, rng: random.Random) -> bytes:
    """Return the data damaged in the way of their format, or in any."""
    if rng.random() < 0.03:
        return made_up(rng)
    inside = next((way for magic, way in STRUCTURED if data.lstrip()[: len(magic)] == magic), None)
    if inside is not None and rng.random() < 0.75:
        with contextlib.suppress(Exception):  # damaged before, it may be of no format
            return inside(data, rng)
    is_text = b"\0" not in data[:4096]
    return (damaged_text if is_text and rng.random() < 0.7 else damaged_bytes)(data, rng)


# What is read

Rng = random.Random | None  # for options of a reader, which are left alone for a valid file


@attrs.frozen
class Target:
    """A kind of file or folder: who writes a valid one into a folder, and who reads it."""

    write: Callable[[Path], object]
    read: Callable[[Path, Rng], object]


def the_file(folder: Path, name: str) -> Path:
    """Return the one file of that name, or the first with that ending."""
    return next(iter(sorted(folder.glob(name))), folder / name.lstrip("*"))


def _trace(path: Path, rng: Rng, stated: dict[str, Any] | None = None) -> None:
    from hmdwarp.poses import TraceOptions, analyse, load_trace
    from hmdwarp.poses.formats import formats

    stated = dict(stated or {})
    if rng is not None and rng.random() < 0.4:
        stated |= {
            "format": rng.choice([None, *formats.names()]),
            "quat_order": rng.choice([None, "xyzw", "wxyz"]),
            "up": rng.choice([None, "0,0,1", "x,y,z", "0.1,1,0.2"]),
            "scale": rng.choice([None, 0.01, 1e6]),
            "rate": rng.choice([None, 90.0, 1e-3]),
            "segment": rng.choice([None, 1, 2]),
        }
    track = load_trace(path, TraceOptions(**stated)).track
    assert len(track) >= 2 and track.start_ns == 0
    for instant in (-1, 0, track.end_ns // 2, track.end_ns + 1):
        track.at(instant)
    analyse(track, latencies_ms=(20,))


SAMPLES = {
    "unity": "vectors-unity-in-quotes.csv", "iwer": "iwer.json", "json": "json-columns-and-data.json",
    "motive": "motive.csv", "qualisys": "qualisys.tsv", "unreal": "unreal-rotator.csv", "eyenavgs": "eyenavgs.csv",
    "browser": "browser.json", "bids": "bids-quaternions",
}  # fmt: skip


Add = Callable[..., None]  # name, who writes, who reads, the package that it needs


def _traces(add: Add) -> None:
    from poses import layouts
    from poses.traces import head, rows, save
    from recorded_folders import taken, write_colmap
    from ros_bags import BEGINS_NS

    from hmdwarp.base import resources
    from hmdwarp.poses.formats import formats

    def reads(name: str = "trace*", stated: dict[str, Any] | None = None) -> Callable[[Path, Rng], None]:
        return lambda folder, rng: _trace(the_file(folder, name), rng, stated)

    track = head(60)
    for layout in layouts.LAYOUTS:
        add(f"trace {layout.name}", partial(layouts.written, layout, track), reads("*", layout.stated))
    there = track.evolve(epoch_ns=BEGINS_NS)
    for name in (form.name for form in formats if form.writes):
        saves = partial(lambda name, folder: save(there, folder / f"trace.{name}", name), name)
        add(f"trace {name}", saves, reads())
    table = rows(track, "wxyz")
    texts = {
        "multi": ["timestamp viewpoint w x y z", *(" ".join([r[0], "0", *r[4:]]) for r in table)],
        "frames": [" ".join([r[0], str(i), *r[4:]]) for i, r in enumerate(table)],
        "ticks": [",".join([str(638 * 10**15 + i * 166667), *r[1:]]) for i, r in enumerate(table)],
        "recording": [(resources.folder("recordings") / "walk.csv").read_text()[:20_000]],
    }
    for name, lines in texts.items():
        writes = partial(lambda text, folder: (folder / "trace.csv").write_text(text), "\n".join(lines))
        add(f"trace {name}", writes, reads(stated={"quat_order": "wxyz"} if name == "ticks" else None))
    for name, sample in SAMPLES.items():
        path = HERE.parent / "poses" / "files" / sample
        copies = partial(shutil.copytree, path, dirs_exist_ok=True) if path.is_dir() else partial(shutil.copy, path)
        add(f"trace {name}", copies, reads("*motion.tsv" if name == "bids" else "*"))
    images = reads("sparse/0/images.txt", {"rate": 90.0})
    add("trace colmap", lambda folder: write_colmap(folder, taken(3)), images)


def _sequences(add: Add) -> None:
    from recorded_folders import taken
    from ros_bags import BAGS, FORMS

    def read(form: Any, folder: Path, rng: Rng) -> None:
        from hmdwarp.sources import sequences

        for frame in sequences.open(folder, form.options).frames[:4]:
            frame.read()

    def bag(folder: Path, rng: Rng) -> None:
        _trace(next(path for path in sorted(folder.iterdir()) if path.suffix in (".bag", ".db3", ".mcap")), rng)

    for name, form in FORMS.items():
        needs = "rosbags" if name in BAGS else "OpenEXR" if name == "exr" else None
        writes = partial(lambda form, folder: form.write(folder, taken(3)), form)
        add(f"frames {name}", writes, partial(read, form), needs)
        if name in BAGS:
            add(f"trace {name}", writes, bag, needs)


def _frame_files(add: Add) -> None:
    from hmdwarp.sources.sequences import frame_files

    def write(pack: Callable[..., None], folder: Path) -> None:
        facts = {"fov": [-0.6, 0.6, -0.5, 0.5], "position_m": [0, 1, 2], "orientation_xyzw": [0, 0, 0, 1]}
        (folder / "pose.json").write_text(json.dumps(facts))
        pack(folder / "frame.npz", colour=np.full((8, 10, 3), 9, np.uint8), depth_m=np.full((8, 10), 2.0), **facts)

    for name, pack in (("stored", np.savez), ("packed", np.savez_compressed)):
        add(f"frame {name}", partial(write, pack), lambda folder, _: frame_files.read_frame(folder / "frame.npz"))
    add("pose", partial(write, np.savez), lambda folder, _: frame_files.read_view(folder / "pose.json"))


def _scenes(add: Add) -> None:
    import trimesh
    from scenes.glb import Glb

    def read(ending: str, folder: Path, rng: Rng) -> None:
        from hmdwarp.scenes import SceneOptions, load_scene

        animation = "all" if rng is not None and ending.startswith("gl") and rng.random() < 0.5 else None
        load_scene(folder / f"scene.{ending}", SceneOptions(animation=animation))

    def glb() -> Glb:
        made = Glb().skin().animate("rotation", (0, 1), ((0, 0, 0, 1), (0, 1, 0, 0)), node=2)
        picture = np.full((8, 8, 4), 200, np.uint8)
        return made.material(alphaMode="BLEND", pbrMetallicRoughness={"baseColorTexture": made.texture(picture)})

    add("scene glb", lambda folder: (folder / "scene.glb").write_bytes(glb().data()), partial(read, "glb"))
    for name, inside in (("whole", True), ("with files", False)):
        writes = partial(lambda inside, folder: glb().write_gltf(folder / "scene.gltf", inside=inside), inside)
        add(f"scene gltf {name}", writes, partial(read, "gltf"))
    for ending in ("obj", "ply"):
        exports = partial(lambda name, folder: trimesh.creation.box().export(folder / name), f"scene.{ending}")
        add(f"scene {ending}", exports, partial(read, ending))


def _tables(add: Add) -> None:
    from hmdwarp.client.classes import load_client
    from hmdwarp.headsets import load_headset
    from hmdwarp.study.analysis.findings import load_claims
    from hmdwarp.study.analysis.long_table import from_csv
    from hmdwarp.study.design import load_design
    from hmdwarp.study.respondents import load_model
    from hmdwarp.study.scales import load_scale

    kinds: dict[str, tuple[str, Callable[[str], object]]] = {
        "headset": ("headsets/*.toml", load_headset),
        "client": ("client/classes/*.toml", load_client),
        "scale": ("study/scales/*.toml", load_scale),
        "model": ("study/respondents/*.toml", load_model),
        "study": ("study/ready/[!_]*.toml", partial(load_design, checked=False)),
        "claims": ("study/ready/*_claims.toml", lambda name: load_claims(Path(name))),
        "ratings": ("study/ready/*_ratings.csv", lambda name: from_csv(Path(name))),
    }
    for kind, (where, load) in kinds.items():
        for file in sorted((ROOT / "hmdwarp").glob(where)):
            if kind != "study" or "_" not in file.stem:
                reads = partial(lambda load, name, folder, _: load(str(folder / name)), load, file.name)
                add(f"{kind} {file.stem}", partial(shutil.copy, file), reads)


def _results(add: Add) -> None:
    from bench_files import a_bench, a_row

    from hmdwarp.link.delays import read_delays
    from hmdwarp.pipeline.governor import read_rows

    def benches(folder: Path) -> None:
        from hmdwarp.metrics import blocks_text

        for host in ("one", "two"):
            machine = {"host": host, "gl_renderer": "any", "gl_version": "4.5", "cpu_count": 1}
            row = a_row("none", "none", 1.0, 0.3, machine=machine, blocks={"3": blocks_text(np.zeros((2, 2, 3)))})
            about = {"hmdwarp": "0", "program": "this", "clock": "wall", "clocks": {}, "notes": []}
            (folder / host).mkdir()
            a_bench(folder / host / "bench.json", [row], machine=machine, seconds=1.0, **about)

    def merge(folder: Path, rng: Rng) -> None:
        from unittest.mock import patch

        from hmdwarp.experiments.bench import MergeOptions, merge

        # The page needs all that a real bench has.
        with patch.object(sys.modules[merge.__module__], "write_bench"):
            merge(MergeOptions(folders=(folder / "one", folder / "two"), out=folder / "merged"))

    add("bench merge", benches, merge)
    rows, delays = {"schema": 1, "rows": [a_row("none", "none", 1.0, 0.3)] * 2}, "delay\n" + "12.5\n80 # late\n" * 9
    for name, file, text, reads in (
        ("bench", "bench.json", json.dumps(rows), read_rows),
        ("delays", "delays.txt", delays, read_delays),
    ):
        writes = partial(lambda file, text, folder: (folder / file).write_text(text), file, text)
        add(name, writes, partial(lambda reads, file, folder, _: reads(folder / file), reads, file))


def _secrets(add: Add) -> None:
    def write(folder: Path) -> None:
        from hmdwarp.sources.feed.options import key_pair

        key_pair(folder / "feed")
        (folder / "token").write_text("thirty-two letters of any kind..")

    def read(folder: Path, rng: Rng) -> None:
        from hmdwarp.sources.feed.options import public_key, secret_in

        public_key(folder / "feed.key")
        secret_in(folder / "token")

    add("key and token", write, read, "zmq")


def targets() -> dict[str, Target]:
    """Return all that this machine has the packages for, by name."""
    found: dict[str, Target] = {}

    def add(name: str, write: Callable, read: Callable, needs: str | None = None) -> None:
        if needs is None or importlib.util.find_spec(needs):
            found[name] = Target(write, read)

    for kind in (_traces, _sequences, _frame_files, _scenes, _tables, _results, _secrets):
        kind(add)
    return found


# Cases


@attrs.frozen
class Outcome:
    """How one case ended."""

    status: int
    text: str


def in_child(work: Callable[[], int], told: Path) -> Outcome:
    """Run it in a process of its own, with limits; what it writes goes to `told`."""
    told.unlink(missing_ok=True)
    had = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    child = os.fork()
    if not child:
        try:
            descriptor = os.open(told, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            os.dup2(descriptor, 1)
            os.dup2(descriptor, 2)
            signal.setitimer(signal.ITIMER_REAL, MOST_WALL_S)
            resource.setrlimit(resource.RLIMIT_CPU, (MOST_CPU_S, MOST_CPU_S + 1))
            resource.setrlimit(resource.RLIMIT_AS, (had + MOST_MIB * 2**20,) * 2)
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            os._exit(work())
        except BaseException:
            os.write(2, traceback.format_exc().encode())
        finally:
            os._exit(FAULT)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    text = told.read_text(errors="replace") if told.exists() else ""
    ended = {-signal.SIGXCPU: f"over {MOST_CPU_S} s of CPU", -signal.SIGALRM: f"hangs for {MOST_WALL_S} s"}
    if code < 0:
        text += ended.get(code) or f"killed by {signal.Signals(-code).name}"
    return Outcome(code, text)


def read(target: Target, folder: Path, seed: str | None) -> int:
    """Return READ or REFUSED; anything else is raised. seed: of the options, None for none."""
    from hmdwarp.base import InputError

    warnings.simplefilter("ignore")
    try:
        target.read(folder, None if seed is None else random.Random(seed))
    except InputError as error:
        assert str(error) and "\n" not in str(error), f"not one line: {str(error)!r}"
        print(error)
        return REFUSED
    return READ


def _valid(target: Target, folder: Path) -> int:
    """Write and read a valid one, and print the modules that it took."""
    target.write(folder)
    status = read(target, folder, None)
    if status == READ:
        print("\n".join(sys.modules), flush=True)
    return status


class Fuzzer:
    """Valid files of every target, and cases made of them."""

    def __init__(self, folder: Path, seed: str, only: str) -> None:
        self.folder, self.seed = folder, seed
        self.targets = {name: one for name, one in targets().items() if only in name}
        for number, (name, one) in enumerate(self.targets.items()):
            where = folder / "valid" / str(number) / IN
            where.mkdir(parents=True)
            made = in_child(partial(_valid, one, where), folder / "told")
            assert made.status == READ, f"{name}: {made.text}"
            # Else each case imports them again.
            for module in made.text.split():
                with contextlib.suppress(Exception):
                    importlib.import_module(module)

    def case(self, number: int) -> tuple[str, Path, str]:
        """Return the name of a target, a folder with a damaged copy, and a seed for options."""
        name, seed = list(self.targets)[number % len(self.targets)], f"{self.seed}-{number}"
        rng, folder = random.Random(seed), self.folder / "case"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.folder / "valid" / str(number % len(self.targets)), folder)
        files = sorted(path for path in folder.rglob("*") if path.is_file())
        for _ in range(rng.choice([1, 1, 1, 2, 4])):
            path = rng.choice(files)
            path.write_bytes(damaged(path.read_bytes(), rng))
        return name, folder, seed

    def run(self, number: int) -> tuple[str, Outcome]:
        """Try one case."""
        name, folder, seed = self.case(number)
        return name, in_child(lambda: read(self.targets[name], folder / IN, seed), self.folder / "told")


def keep(fuzzer: Fuzzer, number: int, name: str, outcome: Outcome, out: Path) -> str:
    """Save a finding, and return a command that repeats it."""
    _, folder, seed = fuzzer.case(number)
    kept = out / f"{re.sub('[^a-z0-9]+', '-', name.lower())}-{fuzzer.seed}-{number}"
    shutil.rmtree(kept, ignore_errors=True)
    shutil.copytree(folder, kept / "case")
    (kept / "finding.json").write_text(json.dumps({"target": name, "seed": seed, "text": outcome.text}))
    return f".venv/bin/python tests/fuzz.py --again {kept}"


def again(kept: Path) -> int:
    """Read a finding here, without limits."""
    said = json.loads((kept / "finding.json").read_text())
    status = read(targets()[said["target"]], kept / "case" / IN, said["seed"])
    print({READ: "read", REFUSED: "refused in one line"}[status])
    return 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=float("inf"), help="how long")
    parser.add_argument("--cases", type=int, default=10**9, help="how many cases")
    parser.add_argument("--seed", default="1", help="another seed, other damage")
    parser.add_argument("--only", default="", help="targets with this in their name")
    parser.add_argument("--out", type=Path, default=Path("out/fuzz"), help="where findings are kept")
    parser.add_argument("--again", type=Path, help="the folder of a finding, to be read with its traceback")
    options = parser.parse_args()
    if options.again:
        return again(options.again)
    ends, ended, found = time.monotonic() + options.seconds, Counter[int](), Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        fuzzer = Fuzzer(Path(folder), options.seed, options.only)
        for number in range(options.cases):
            if time.monotonic() > ends:
                break
            name, outcome = fuzzer.run(number)
            ended[outcome.status] += 1
            if outcome.status not in (READ, REFUSED):
                last = (outcome.text.strip().splitlines() or ["it ended"])[-1][:200]
                found[name] += 1
                if found[name] <= 5:
                    print(f"{name}: {last}\n  {keep(fuzzer, number, name, outcome, options.out)}", flush=True)
    tried = sum(ended.values())
    print(
        f"fuzz: seed {options.seed}, {len(fuzzer.targets)} targets, {tried} cases: {ended[READ]} read, "
        f"{ended[REFUSED]} refused, {found.total()} findings"
    )
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

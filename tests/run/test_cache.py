"""--cache: true pictures and figures of earlier runs, taken instead of made."""

from __future__ import annotations

import json
from pathlib import Path

import attrs
import numpy as np
import pytest
from replays import contents, rows_of, run, small

from hmdwarp.errors import HmdwarpError
from hmdwarp.experiments.bench import CompareOptions
from hmdwarp.options.identity import identity_of
from hmdwarp.run.cache import Cache
from hmdwarp.run.options import CacheOptions

FIGURES = ("psnr_db", "ssim", "flip", "hole_share", "border_share", "flicker")


def told(folder: Path) -> tuple[object, ...]:
    """All that a run says of pictures."""
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    pictures = {name: data for name, data in contents(folder).items() if name.endswith(".png")}
    rows = [[row[name] for name in FIGURES] for row in rows_of(folder)]
    compared = [other["quality"] for other in summary["against"]]
    return json.dumps([summary["quality"], summary["regions"], compared]), rows, pictures


def replayed(gpu, out: Path, cache: Path | None, **options: object) -> tuple[tuple[object, ...], list[str]]:
    given = {"scene": "planes", "against": "none", "fill": "interpolate", "images": 2, "samples": 2, **options}
    result = run(out, gpu=gpu, cache=CacheOptions(folder=cache), **given)
    return told(out), result.summary["notes"]


@pytest.mark.parametrize("by", ["gpu", "library"])
def test_figures_and_pictures_are_those_without_it(gpu, tmp_path, by):
    """Also where half of the entries are damaged, which is noted once."""
    cache = tmp_path / "cache"
    without, notes = replayed(gpu, tmp_path / "without", None, metrics_by=by)
    assert replayed(gpu, tmp_path / "first", cache, metrics_by=by) == (without, notes)
    kept = contents(cache)
    assert replayed(gpu, tmp_path / "second", cache, metrics_by=by) == (without, notes)
    assert contents(cache) == kept
    for number, path in enumerate(sorted(cache.iterdir())[::2]):
        data = path.read_bytes()
        path.write_bytes([b"", data[: len(data) // 2], data.replace(data[-400:-300], bytes(100))][number % 3])
    again, noted = replayed(gpu, tmp_path / "again", cache, metrics_by=by)
    assert again == without and contents(cache) == kept
    (new,) = set(noted) - set(notes)
    assert "damaged" in new and str(cache) in new


def test_what_is_kept_is_taken(gpu, tmp_path):
    """A true picture that was changed shows in the figures, if its figures are not kept too."""
    without, _ = replayed(gpu, tmp_path / "first", tmp_path / "cache")
    changed = 0
    for path in (tmp_path / "cache").iterdir():
        with np.load(path) as found:
            arrays = dict(found)
        if "picture" in arrays:
            np.savez(path, **{**arrays, "picture": 255 - arrays["picture"]})
            changed += 1
        else:
            path.unlink()
    again, _ = replayed(gpu, tmp_path / "again", tmp_path / "cache")
    assert changed and again[0] != without[0]


@pytest.mark.parametrize(
    "options", [{"scene": "spheres"}, {"samples": 4}, {"size": (80, 96)}, {"start_s": 0.4}], ids=lambda one: [*one][0]
)
def test_other_pictures_are_not_taken_for_those(gpu, tmp_path, options):
    replayed(gpu, tmp_path / "first", tmp_path / "cache")
    without, _ = replayed(gpu, tmp_path / "without", None, **options)
    assert replayed(gpu, tmp_path / "second", tmp_path / "cache", **options)[0] == without


def test_the_folder_stays_within_its_bound_and_keeps_what_was_used_last(tmp_path):
    """20 entries of 4 kB in 40 kB: never above, and the one that is read again stays."""
    cache = Cache(CacheOptions(folder=tmp_path, most_mb=0.04), "test", [])
    keys = [cache.key("entry", number) for number in range(20)]
    for number, key in enumerate(keys):
        cache.put(key, {"numbers": np.full(1000, number, np.int32)})
        assert cache.get(keys[0], lambda found: int(found["numbers"][0])) == 0
        assert sum(map(len, contents(tmp_path).values())) <= 40_000
    there = [key for key in keys if cache.get(key, lambda found: found["numbers"].sum()) is not None]
    assert there[0] == keys[0] and there[1:] == keys[-len(there) + 1 :] and len(there) >= 7


def test_it_is_no_part_of_what_a_run_is(tmp_path):
    """A set of cases is resumed whether it had a cache or not."""
    options = CompareOptions(recordings=("walk",))
    kept = attrs.evolve(options, cache=CacheOptions(folder=tmp_path))
    assert identity_of("kind", kept) == identity_of("kind", options) and kept.of_run()["cache"] == kept.cache


def test_a_folder_that_cannot_be_made_is_named(gpu, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(HmdwarpError, match="file"):
        run(tmp_path / "out", gpu=gpu, cache=CacheOptions(folder=tmp_path / "file" / "in"))
    assert not (tmp_path / "out").exists()
    assert small().cache.folder is None

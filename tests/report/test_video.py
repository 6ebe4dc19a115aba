"""The video: true colours, any size and rate, and nothing left behind by a failure."""

import numpy as np
import pytest

from hmdwarp.base import HmdwarpError, InputError, MachineError
from hmdwarp.report import open_video, video

av = pytest.importorskip("av")

COLOURS = [
    *((255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)),
    *((0, 0, 0), (128, 128, 128), (200, 100, 50), (12, 200, 220)),
]


def bars(width: int, height: int) -> np.ndarray:
    """Vertical bars of COLOURS."""
    return np.array(COLOURS, np.uint8)[np.arange(width) * len(COLOURS) // width][None].repeat(height, axis=0)


def decoded(path) -> tuple[list[np.ndarray], object]:
    """All pictures as RGB, converted by what the file's own tags say, and the stream's context."""
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)], stream


@pytest.mark.parametrize("size", [(256, 64), (255, 67), (17, 16)])
def test_known_colours_survive(size, tmp_path):
    """Limited range has 219 steps of luma and 224 of chroma.

    Half a step of each is at most 0.6 + 1.86 * 0.57 = 1.7 levels of blue.

    The same once more for the decoder's rounding, and 2 levels for the quantiser at its setting
    (step 5, of which a flat block loses less than half): 5 levels. With BT.601 for BT.709, or the
    range mistaken, greens and reds are off by 16 and more.
    """
    width, height = size
    picture = bars(width, height)
    with open_video(tmp_path / "a.mp4", size, 30) as add:
        for _ in range(3):
            add(picture)
    pictures, stream = decoded(tmp_path / "a.mp4")
    assert len(pictures) == 3 and pictures[0].shape == (height + height % 2, width + width % 2, 3)
    context = stream.codec_context
    assert (context.name, context.pix_fmt) == ("h264", "yuv420p")
    assert (context.colorspace, context.color_primaries, context.color_trc, context.color_range) == (1, 1, 1, 1)
    # Odd sides repeat their edge: a black border would be off by 250.
    assert all(np.abs(shown[-1].astype(int) - shown[0]).max() <= 5 for shown in pictures)
    if width < 32:
        return  # bars of 2 pixels have no unmixed chroma
    columns = [*(round((i + 0.5) * width / len(COLOURS)) for i in range(len(COLOURS))), -1]
    for shown in pictures:
        assert np.abs(shown[height // 2, columns].astype(int) - [*COLOURS, COLOURS[-1]]).max() <= 5


@pytest.mark.parametrize("rate", [25, 89.97, 90.0, 30000 / 1001, 7.5])
def test_rate_and_order(rate, tmp_path):
    with open_video(tmp_path / "a.mp4", (32, 32), rate) as add:
        for level in range(0, 250, 25):
            add(np.full((32, 32, 3), level, np.uint8))
    pictures, stream = decoded(tmp_path / "a.mp4")
    assert float(stream.average_rate) == pytest.approx(rate, rel=1e-5)
    means = [p.mean() for p in pictures]
    assert len(means) == 10 and means == sorted(means)
    assert float(stream.duration * stream.time_base) == pytest.approx(10 / rate, rel=1e-3)


def test_the_same_pictures_give_the_same_file(tmp_path):
    for name in ("a.mp4", "b.mp4"):
        with open_video(tmp_path / name, (64, 48), 30) as add:
            for seed in range(5):
                add(np.random.default_rng(seed).integers(0, 256, (48, 64, 3), dtype=np.uint8))
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()


ANOTHER = [np.zeros((32, 31, 3), np.uint8), np.zeros((32, 32), np.uint8), np.zeros((32, 32, 3))]


@pytest.mark.parametrize("picture", ANOTHER, ids=["size", "grey", "floats"])
def test_pictures_of_another_kind(picture, tmp_path):
    with pytest.raises(HmdwarpError, match="picture of shape"), open_video(tmp_path / "a.mp4", (32, 32), 30) as add:
        add(picture)


@pytest.mark.parametrize(
    "size, rate", [((8, 32), 30), ((32, 32), 0), ((32, 32), -1), ((32, 32), float("nan")), ((32, 32), float("inf"))]
)
def test_sizes_and_rates_that_make_no_video(size, rate, tmp_path):
    with pytest.raises(InputError, match="video of"), open_video(tmp_path / "a.mp4", size, rate):
        pass
    assert list(tmp_path.iterdir()) == []


def test_what_the_machine_lacks_is_said(tmp_path, monkeypatch):
    (tmp_path / "a.mp4").symlink_to("/dev/full")
    cannot = {"missing/a.mp4": (InputError, r"missing/a\.mp4: cannot write"), "a.mp4": (MachineError, "make room")}
    for name, (kind, said) in cannot.items():
        with pytest.raises(kind, match=said), open_video(tmp_path / name, (32, 32), 30) as add:
            add(np.zeros((32, 32, 3), np.uint8))
    monkeypatch.setattr(video, "ENCODERS", {"libnothing264": {}})
    lacks = "built without libopenh264 and libx264.*pip install av"
    with pytest.raises(MachineError, match=lacks), open_video(tmp_path / "b.mp4", (32, 32), 30):
        pass

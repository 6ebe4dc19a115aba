"""What became of the frames and of the holes, as people read it."""

import pytest

from hmdwarp.report import coding_rows, filled_rows, frame_rows, model_rows, response_rows

from .samples import a_summary


def test_each_part_stands_once_and_empty_ones_are_left_out():
    summary = a_summary()
    assert filled_rows(summary) == [("fill memory", "3.10 %"), ("fill pyramid", "2.00 %"), ("left empty", "0.00 %")]
    assert "waiting for earlier frames" not in dict(response_rows(summary))
    rows = response_rows(summary)
    assert rows[-3:] == [
        ("latency plus this machine's stages (mean: the sum of these)", "272.30 ms"),
        ("latency plus this machine's stages (median)", "268.40 ms"),
        ("latency plus this machine's stages (95th percentile)", "301.20 ms"),
    ]
    assert sum(float(text.split()[0]) for _, text in rows[:-3]) == pytest.approx(272.3, abs=0.05)
    assert dict(frame_rows(summary)) == {
        "drawn": "120", "sent": "120", "of these lost on the network": "3",
        "of these too late (a newer one was shown)": "1",
        "of these superseded (a newer one arrived for the same refresh)": "2",
        "shown": "100", "in transit at the end": "14",
    }  # fmt: skip
    assert coding_rows(summary)[:2] == [
        ("rate, both eyes", "21.4 Mbit/s"),
        ("of that", "inverse depth 12.1, colour 9.3"),
    ]
    labels = [label for label, _ in (*response_rows(summary), *coding_rows(summary))]
    assert len(labels) == len(set(labels))  # encoding stands in both, by two names


def test_without_entries_there_are_no_rows():
    summary = a_summary()
    frames = {"drawn": 10, "sent": 10, "shown": 8, "under_way": 2}
    plain = {"codec": "none", "mbit_s": 100.0, "frames": frames, "response_ms": None}
    assert coding_rows({"link": plain}) == [("rate, both eyes", "100.0 Mbit/s uncompressed")]
    bare = {key: value for key, value in summary.items() if key not in ("link", "filled")}
    for rows in (filled_rows, response_rows, frame_rows, coding_rows, model_rows):
        assert rows(bare) == []


def test_each_model_of_the_client_and_its_transfer_have_a_line():
    model = {"share": 0.2, "texture": 0.25, "triangles": 15064, "geometry_bytes": 912_345, "texture_bytes": 1_234_567}
    summary = {**a_summary(), "client_models": [model, {**model, "share": 1.0, "texture": 1.0}]}
    (name, weight), (whole, _) = model_rows(summary)
    assert name == "client's model, 20 % of the triangles, textures at 0.25"
    assert whole == "client's model, 100 % of the triangles, textures at 1"
    assert weight == "15064 triangles 0.9 MB, textures 1.2 MB"
    crossed = {"start_up_bytes": 20_000, "first_picture_bytes": 64_400, "arrived_bytes": 9_000_000}
    for first, words in ((64_400, "0.06 MB before the first whole picture"), (None, "no whole picture")):
        _, row = model_rows({"client_models": [{**model, **crossed, "first_picture_bytes": first}]})
        assert row == ("of that crossed, packed", f"0.02 MB at the start, {words}, 9.00 MB in all")

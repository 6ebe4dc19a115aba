"""Strips, labels, the error map's colours, and files that hold what they were given."""

import io

import numpy as np
import pytest
from PIL import Image

from hmdwarp.report import comparison_columns, in_a_row, jpeg_bytes, labelled_strip, magma, png_bytes
from hmdwarp.report.files import panels_in

from .samples import a_scene


def find(strip: np.ndarray, panel: np.ndarray) -> tuple[int, int] | None:
    """Where (row, column) a panel lies in a strip, pixel for pixel."""
    windows = np.lib.stride_tricks.sliding_window_view(strip, panel.shape)[:, :, 0]
    for row, column in np.argwhere((windows[:, :, 0, 0] == panel[0, 0]).all(axis=-1)).tolist():
        if np.array_equal(windows[row, column], panel):
            return row, column
    return None


def test_every_panel_is_there_unchanged_in_order_and_labelled():
    error = np.arange(200 * 320, dtype=np.uint32).reshape(200, 320).astype(np.uint8)
    warped = [("warped", a_scene(2), error), ("forward", a_scene(3), error)]
    panels = in_a_row(comparison_columns(a_scene(9), a_scene(0), warped))
    strip = labelled_strip(panels)
    places = [find(strip, picture) for _, picture in panels]
    assert None not in places
    assert [name for name, _ in panels] == ["truth", "late frame", "warped", "forward", "error (FLIP 0 to 0.5)"]
    columns = [column for _, column in places]
    assert columns == sorted(columns) and columns[0] == 0
    for row, column in places:
        label = strip[:row, column : column + 320]
        assert (label.min(axis=-1) < 128).sum() > 30  # ink of the label above it
        assert (label == 255).all(axis=-1).mean() > 0.8


@pytest.mark.parametrize("size", [(1, 1), (33, 21), (640, 400), (641, 401)])
def test_a_strip_gives_its_panels_back_in_the_height_of_the_first(size):
    first, others = a_scene(size=size), [a_scene(size=(160, 100)), a_scene(size=(64, 40))]
    strip = labelled_strip([("x", one) for one in (first, *others, first)])
    found = panels_in(strip, 4, size[1])
    assert {one.shape for one in found} == {(size[1], found[0].shape[1], 3)}
    for panel in (found[0], found[-1]):
        assert np.array_equal(panel[:, : size[0]], first) and (panel[:, size[0] :] == 255).all()  # white beside it


def test_magma_rises_from_black_to_bright_and_takes_bytes_or_floats():
    levels = np.arange(256, dtype=np.uint8).reshape(16, 16)
    colours = magma(levels)
    assert np.array_equal(colours, magma(levels / 255)) and colours.shape == (16, 16, 3)
    luma = colours.reshape(-1, 3) @ [0.2126, 0.7152, 0.0722]
    assert luma[0] < 3 and luma[-1] > 240 and (np.diff(luma) > -1).all()
    assert np.array_equal(magma(np.array([[-1.0, 2.0]])), magma(np.array([[0.0, 1.0]])))


@pytest.mark.parametrize("picture", [a_scene(), a_scene()[::-1, ::-1], a_scene()[..., 0]])
def test_png_keeps_every_byte_and_jpeg_is_close_and_small(picture):
    with Image.open(io.BytesIO(png_bytes(picture))) as image:
        assert np.array_equal(np.asarray(image), picture)
    if picture.ndim == 3:
        with Image.open(io.BytesIO(jpeg := jpeg_bytes(picture))) as image:
            # Steps of the quantiser at quality 90 are 2 to 10.
            assert np.abs(np.asarray(image).astype(int) - picture).mean() < 3 and len(jpeg) < picture.size / 4

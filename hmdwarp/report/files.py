"""Atomic files: partial output never has a final name."""

from __future__ import annotations

import csv
import errno
import functools
import io
import json
import os
import re
import shutil
import uuid
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import HmdwarpError, InputError, MachineError, platforms

_STEM = 60  # characters of a name that a partial file's name has
_NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
_FORBIDDEN = frozenset({errno.EACCES, errno.EPERM, errno.EROFS})
_NO_PLACE = frozenset({errno.ENOENT, errno.ENAMETOOLONG, errno.ENOTEMPTY})


def write_error(error: OSError, path: Path) -> HmdwarpError:
    """Return the error of a failed write: MachineError for a full disk, else InputError."""
    why = error.strerror or str(error)
    if error.errno in (errno.EEXIST, errno.ENOTDIR):
        return InputError(
            f"{path}: cannot write, because a file is in the place of a folder: choose a folder, or a new name"
        )
    if error.errno == errno.EISDIR:
        return InputError(f"{path}: cannot write, because it is a directory: expected the name of a file")
    if error.errno in _NO_ROOM:
        return MachineError(f"{path}: cannot write ({why}): make room or choose another folder")
    if error.errno in _FORBIDDEN | _NO_PLACE:
        return InputError(f"{path}: cannot write ({why}): choose a folder that you may write to")
    return MachineError(f"{path}: cannot write ({why})")


@attrs.define
class Partial:
    """A hidden file or folder that is being written, less what killed runs left of its name.

    It holds a lock while it lives, so that no other run takes it for one left behind.
    """

    path: Path
    _handle: int
    # Those left behind that held this file.
    ended: int = 0

    @classmethod
    def of(cls, final: Path) -> Partial:
        """Make a file beside its final place. Errors: OSError."""
        return cls.make(final.parent, f".{final.name[:_STEM]}.", ".part")

    @classmethod
    def make(
        cls, parent: Path, begin: str, end: str = "", *, mode: int = 0o777, is_folder: bool = False, last: str = ""
    ) -> Partial:
        """Make a file or folder of such a name; last: counts in `ended`. Errors: OSError."""
        gone = (FileNotFoundError,) if is_folder else ()
        while True:
            path, flags = parent / f"{begin}{uuid.uuid4().hex[:8]}{end}", os.O_CREAT | os.O_EXCL | os.O_WRONLY
            if is_folder:
                path.mkdir(mode=mode)
                flags = os.O_RDONLY
            with suppress(*gone):  # another run found it before it was locked
                found = cls(path, os.open(path, flags, 0o666))
                lock(found._handle, wait=True)
                if path.exists():
                    break
                os.close(found._handle)
        ours = re.compile(rf"{re.escape(begin)}[0-9a-f]{{8}}{re.escape(end)}")
        for left in os.scandir(parent):
            kind = left.is_dir if is_folder else left.is_file
            if left.path == str(path) or not ours.fullmatch(left.name) or not kind(follow_symlinks=False):
                continue
            with suppress(OSError):  # another user's, or deleted by another run
                handle = os.open(left.path, os.O_RDONLY)
                try:
                    if lock(handle):
                        other = cls(Path(left.path), -1)
                        found.ended += bool(last) and (other.path / last).exists()
                        other.close()
                finally:
                    os.close(handle)
        return found

    def close(self) -> None:
        """Delete it, where it is still there."""
        if self.path.is_dir():
            shutil.rmtree(self.path, ignore_errors=True)
        with suppress(OSError):
            self.path.unlink()
        if self._handle >= 0:
            os.close(self._handle)
            self._handle = -1


def lock(handle: int, *, wait: bool = False) -> bool:
    """Lock an open file or folder until it is closed; return whether it was free."""
    try:
        platforms.lock(handle, wait=wait)
    except OSError:
        return False
    return True


@contextmanager
def atomic(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path next to `path`; it takes the final name when the block ends.

    If the block fails, it is deleted; if the process is killed, by the next that writes `path`.

    Errors: as write_error, also for an OSError raised inside.
    """
    path = Path(path)
    try:
        partial = Partial.of(path)
        try:
            yield partial.path
            # A full disk may show only here, and a crash must not leave an empty file under the
            # final name.
            sync(partial.path)
            partial.path.replace(path)
        finally:
            partial.close()
    except OSError as error:
        raise write_error(error, path) from error


def keep_private(*paths: Path) -> None:
    """Let only their owner read or enter files and folders, as far as they are ours."""
    for path in paths:
        with suppress(OSError):
            if not path.is_symlink():
                path.chmod(path.stat().st_mode & 0o700)


def sync(path: Path) -> None:
    """Sync a file's content, or a folder's list of files. Errors: OSError."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def write_bytes(path: str | os.PathLike[str], content: bytes) -> None:
    with atomic(path) as temporary:
        temporary.write_bytes(content)


def write_text(path: str | os.PathLike[str], content: str) -> None:
    """Write a text file in UTF-8, lines ending in LF. Errors: as write_bytes."""
    # A file name that is no text (in a command, a note) holds lone surrogates.
    write_bytes(path, content.encode(errors="replace"))


def write_stream(
    path: Path, write: Callable[[IO[Any]], None], source: Path | None = None, *, binary: bool = False
) -> None:
    """Write a file by calling `write` with a stream, which saves memory for a long one.

    source: a file that must not be overwritten. binary: bytes instead of text. Errors: InputError
    for a folder or the source itself; else as write_bytes.
    """
    if path.is_dir():
        raise InputError(f"{path} is a directory: expected the name of a file to write")
    if source is not None:
        refuse_source(path, source)
    how: Any = {"mode": "wb"} if binary else {"mode": "w", "encoding": "utf-8", "newline": "\n"}
    with atomic(path) as temporary, temporary.open(**how) as stream:
        write(stream)


def refuse_source(path: Path, source: Path) -> None:
    """Raise InputError if a file to write is the one that is read, forced or not."""
    if path.exists() and source.exists() and path.samefile(source):
        raise InputError(f"{path} is the input itself: write to another file")


def write_json(path: str | os.PathLike[str], value: Any) -> None:
    """Write indented JSON, keys in their order. Errors: ValueError for NaN and infinity."""
    text = json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False, default=_plain)
    write_bytes(path, f"{text}\n".encode(errors="replace"))  # as write_text


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} has no form in JSON")


def write_csv(path: str | os.PathLike[str], rows: Iterable[Mapping[str, Any]], columns: Sequence[str]) -> None:
    """Write rows under `columns`; None and missing values are empty, floats keep all their digits.

    Texts are inert_text.
    Errors: HmdwarpError for a row with a key that is no column; else as write_bytes.
    """
    with atomic(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        for row in rows:
            if unknown := set(row).difference(columns):
                raise HmdwarpError(
                    f"{path}: a row has {', '.join(sorted(unknown))}, which are no columns of this table"
                )
            writer.writerow([_field(row.get(name)) for name in columns])


_FORMULA = re.compile(r"[\s']*[=+\-@\t\r\n\uff1d\uff0b\uff0d\uff20]")  # the wide ones too, as Excel reads them
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")


def inert_text(text: str) -> str:
    """Return a text for a table, with an apostrophe before one that a spreadsheet would run."""
    return f"'{text}" if _FORMULA.match(text) and not _NUMBER.fullmatch(text) else text


def raw_text(cell: str) -> str:
    """Return the text that inert_text was given."""
    return cell[1:] if cell.startswith("'") and _FORMULA.match(cell[1:]) else cell


def _field(value: Any) -> Any:
    if value is None:
        return ""
    if isinstance(value, str):
        return inert_text(value)
    # repr(np.float64) would write "np.float64(1.0)"; float() is the same number.
    return repr(float(value)) if isinstance(value, float | np.floating) else value


def write_png(path: str | os.PathLike[str], picture: NDArray[Any]) -> None:
    """Write an (h, w, 3) or (h, w) uint8 picture, top row first, as PNG. Errors: as write_bytes."""
    write_bytes(path, png_bytes(picture))


Pixels = NDArray[np.uint8]
Panel = tuple[str, Pixels]
LATE = "late frame"  # the panel that may be wider than the shown ones

# Error maps are brightest here: the mean is near 0.1, and hardly a pixel has 1.
ERROR_TOP = 0.5
_PAPER, _INK, _GAP = (255, 255, 255), (60, 60, 60), 6


def magma(error_map: NDArray[Any]) -> Pixels:
    """Colour an error map, (h, w) bytes or floats 0..1, as FLIP does, from dark to bright."""
    levels = np.asarray(error_map)
    if levels.dtype != np.uint8:
        levels = np.rint(np.clip(levels, 0, 1) * 255).astype(np.uint8)
    return np.asarray(_magma_table()[levels])


@functools.cache
def _magma_table() -> Pixels:
    from matplotlib import colormaps

    table: Pixels = np.rint(np.asarray(colormaps["magma"](np.arange(256)))[:, :3] * 255).astype(np.uint8)
    return table


def comparison_columns(
    rendered: Pixels | None, truth: Pixels, warped: Sequence[tuple[str, Pixels, NDArray[np.uint8]]]
) -> list[list[Panel]]:
    """Return a comparison in columns: truth above late picture, each warped one above its error.

    rendered: None where there is no late picture. warped: name, picture, error map as bytes (which
    is brightest at ERROR_TOP).
    """
    columns = [[("truth", truth), *([] if rendered is None else [(LATE, rendered)])]]
    for name, picture, error_map in warped:
        label = f"error of {name}" if len(columns) > 1 else f"error (FLIP 0 to {ERROR_TOP:g})"
        columns.append([(name, picture), (label, magma(error_map / 255 / ERROR_TOP))])
    return columns


def in_a_row(columns: Sequence[Sequence[Panel]]) -> list[Panel]:
    """Return the panels of a strip: truth, late picture, warped ones, the error of the first."""
    return [*columns[0], *(column[0] for column in columns[1:]), columns[1][1]]


def labelled_strip(panels: Sequence[Panel]) -> Pixels:
    """Lay panels side by side, each with its label above, on white.

    Panels may differ in size: smaller ones are enlarged by repeating pixels, or shrunk, to the
    first one's height.
    Errors: HmdwarpError without any panel.
    """
    from PIL import Image, ImageDraw, ImageFont

    if not panels:
        raise HmdwarpError("a strip of pictures needs at least one panel")
    height = panels[0][1].shape[0]
    images = []
    for image in (Image.fromarray(np.ascontiguousarray(picture)) for _, picture in panels):
        how = Image.Resampling.NEAREST if image.height < height else Image.Resampling.LANCZOS
        size = max(1, round(image.width * height / image.height)), height
        images.append(image if image.height == height else image.resize(size, how))
    cell = max(image.width for image in images) + _GAP
    text = max(11, round(height / 24), round(len(panels) * cell / 80))  # 10 pixels where the strip is shown 800 wide
    font = ImageFont.load_default(text)
    label = round(text * 1.6)
    strip = Image.new("RGB", (len(panels) * cell - _GAP, label + height), _PAPER)
    draw = ImageDraw.Draw(strip)
    for index, ((name, _), image) in enumerate(zip(panels, images, strict=True)):
        draw.text((index * cell + 2, label / 2), name, fill=_INK, font=font, anchor="lm")
        strip.paste(image, (index * cell, label))
    return np.asarray(strip)


def panels_in(strip: Pixels, count: int, height: int) -> list[Pixels]:
    """Return the panels of a labelled_strip of one row, the first of which is so high."""
    cell = (strip.shape[1] + _GAP) // count
    return [strip[-height:, at * cell : (at + 1) * cell - _GAP] for at in range(count)]


def png_bytes(picture: NDArray[Any]) -> bytes:
    """Encode a picture, (h, w, 3) or (h, w) uint8, as a PNG file.

    At zlib's quickest level: a quarter of the time of level 6 for 7 % more bytes.
    """
    return _encoded(picture, "PNG", compress_level=1)


def jpeg_bytes(picture: NDArray[Any]) -> bytes:
    """Encode a picture as a JPEG file without chroma subsampling: about a tenth of the PNG."""
    return _encoded(picture, "JPEG", quality=90, subsampling=0)


def _encoded(picture: NDArray[Any], kind: str, **options: object) -> bytes:
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(picture, dtype=np.uint8)).save(buffer, kind, **options)
    return buffer.getvalue()

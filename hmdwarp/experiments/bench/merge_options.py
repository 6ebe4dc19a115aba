"""Options of `hmdwarp bench merge`."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import attrs

from ...errors import InputError
from ...options import Declared, force_field, option, out_field, path_of
from .options import parquet_field


def _folders(texts: Iterable[str]) -> tuple[Path, ...]:
    return tuple(path_of(text, "DIR") for text in texts)


@attrs.frozen(kw_only=True)
class MergeOptions(Declared):
    """Which benches to join. Errors: InputError for fewer than two folders."""

    folders: tuple[Path, ...] = option(
        attrs.NOTHING, "Folders of benches, two or more.", kind=list, positional=True, metavar="DIR", parse=_folders
    )
    out: Path = out_field(attrs.NOTHING, "Folder for bench.csv, bench.json and bench.html of all.")
    parquet: bool = parquet_field()
    force: bool = force_field()
    command: str = ""

    def __attrs_post_init__(self) -> None:
        if len(self.folders) < 2:
            raise InputError(f"{len(self.folders)} folder to merge: expected two or more")

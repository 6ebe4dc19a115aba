"""hmdwarp study merge: the stores of several sites as one."""

from __future__ import annotations

from pathlib import Path

import attrs
import typer

from ...errors import InputError
from ...options import Declared, option, path_of
from .._options import QUIET, Said, takes


@attrs.frozen
class MergeStoresOptions(Declared):
    """Which stores to join."""

    stores: tuple[str, ...] = option(
        attrs.NOTHING,
        "The folders of data of two or more sites, each after the site's name: berlin=DIR.",
        kind=list,
        positional=True,
        metavar="STORE",
    )
    out: Path = option(attrs.NOTHING, "Folder for the merged store, which must not exist.", kind=Path)


@takes(MergeStoresOptions, QUIET)
def merge(said: Said) -> None:
    """Join the stores of several sites; every command takes the result with --store.

    Participants keep their sessions, and get their site's name before their code.
    """
    from ...report import counted
    from ...study.store import merge as run

    options = MergeStoresOptions.of(said)
    sites: dict[str, Path] = {}
    for text in options.stores:
        site, equals, folder = text.partition("=")
        if not equals:
            raise InputError(f"'{text}': expected SITE=DIR, as in berlin=DIR")
        if site in sites:
            raise InputError(f"site '{site}' is given twice: expected one folder for each")
        sites[site] = path_of(folder, "STORE")
    for rows in run(sites, options.out):
        if not said["quiet"]:
            amounts = (counted(rows.participants, "participant"), counted(rows.sessions, "session"))
            typer.echo(f"{rows.site}: {', '.join(amounts)}, {counted(rows.answers, 'answer')}")
    if not said["quiet"]:
        typer.echo(f"store: {options.out}")

"""The choice of what gives the frames of a run."""

from __future__ import annotations

from ..client.effects import effects
from ..client.lens import lenses
from ..client.variants import parse_fills, parse_indirect, parse_warp
from ..errors import unknown_name
from ..link.codec import check_codec
from ..options import AUTO
from ..poses.predictors import predictors
from ..sources.feed.options import FeedOptions
from ..sources.server.draw import MIRRORS
from .options import PipelineOptions
from .proxy import ProxySource
from .recorded_source import RecordingSource
from .remote_source import RemoteSource
from .source import Source
from .source_kinds import PROXY, RECORDING, REMOTE


def source_of(options: PipelineOptions) -> Source:
    """Return what gives the frames, once all names in the options are known.

    Errors: as check_names; as sequences.open, for recorded frames.
    """
    check_names(options)
    if options.source_kind is RECORDING:
        return RecordingSource.opened(options)
    if options.source_kind is REMOTE:
        feed = getattr(options, "feed", FeedOptions())
        return RemoteSource(options, feed, draws_truth=options.draws_truth)
    return ProxySource(options) if options.source_kind is PROXY else Source(options)


def check_names(options: PipelineOptions) -> None:
    """Check warp, fills, lens, effects, predictor, codec, mirrors, indirect light and network.

    It loads nothing, so that a misspelt name is reported before a scene is built.

    Errors: UnknownNameError; InputError for an impossible network; MachineError for a codec that
    cannot run here.
    """
    if options.warp != AUTO:
        parse_warp(options.warp)
    parse_fills(options.fill)
    if options.lens != AUTO:
        lenses.get(options.lens)
    effects.forced(options.effects)
    predictors.get(options.predict)
    check_codec(options.coding.codec)
    if options.mirrors not in MIRRORS:
        raise unknown_name("kind of mirrors", options.mirrors, list(MIRRORS))
    parse_indirect(options.indirect)
    check_codec(options.proxy.codec)
    options.client_link.check(round(options.latency_ms * 1e6))

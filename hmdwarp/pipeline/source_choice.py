"""The choice of what gives the frames of a run."""

from __future__ import annotations

from ..sources.feed.options import FeedOptions
from .options import PipelineOptions
from .proxy import ProxySource
from .recorded_source import RecordingSource
from .remote_source import RemoteSource
from .source import Source
from .source_kinds import PROXY, RECORDING, REMOTE


def source_of(options: PipelineOptions) -> Source:
    """Return what gives the frames. Errors: as sequences.open, for recorded ones."""
    if options.source_kind is RECORDING:
        return RecordingSource.opened(options)
    if options.source_kind is REMOTE:
        feed = getattr(options, "feed", FeedOptions())
        return RemoteSource(options, feed, draws_truth=options.draws_truth)
    return ProxySource(options) if options.source_kind is PROXY else Source(options)

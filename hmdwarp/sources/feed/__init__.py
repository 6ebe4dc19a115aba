"""Frames from another process or machine: messages, clocks, and both ends (docs/feed.md)."""

EXTRA = "feed"

"""Metrics of one eye's picture: one file each, registered by name."""

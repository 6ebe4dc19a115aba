"""Metrics of one eye's picture, registered by name."""

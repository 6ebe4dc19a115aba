"""Runs around the loop: replay, live and record, with their logs, summaries and measurements."""

"""Experimenter's console: shows how the session goes, and sends the experimenter's commands."""

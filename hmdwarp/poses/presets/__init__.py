"""Axes of head traces by the software that writes them: `reading.axes.presets`."""

"""The loop, live: a headset or a window instead of a trace, and the user may change everything while it runs."""

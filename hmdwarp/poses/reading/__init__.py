"""From bytes to a clean track, in steps: head (what kind of text), columns (which is which), rows (numbers), cleaning (defects)."""

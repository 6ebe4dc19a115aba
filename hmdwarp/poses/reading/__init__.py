"""From bytes to a clean track, in steps: head (which kind of text), columns, rows, cleaning."""

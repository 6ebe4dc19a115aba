"""From bytes to a clean track, in steps: head (file type), columns, rows, cleaning."""

"""So that `python -m hmdwarp.cli` is hmdwarp, where the script is not on the path."""

from . import main

main()

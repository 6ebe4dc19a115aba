"""python -m hmdwarp: the command line."""

from .cli import main

main()

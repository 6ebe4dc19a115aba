"""Errors of decoders."""


class Undecodable(Exception):
    """A frame that cannot be decoded: it is damaged, or what it builds on is missing.

    Neither the program nor the user is at fault: it is counted.
    """

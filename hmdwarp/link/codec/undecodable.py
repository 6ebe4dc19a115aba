"""Errors of decoders."""


class Undecodable(Exception):
    """A frame that cannot be decoded, because it is damaged or a frame it refers to is missing.

    No fault of program or user: such frames are counted.
    """

"""What a decoder says when it cannot go on."""


class Undecodable(Exception):
    """A frame that cannot be decoded: what it builds on is missing, or it is damaged. No fault of ours, nor of the user: it is counted."""

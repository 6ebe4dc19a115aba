"""Export of a study: a long table, and a BIDS data set with the motion of heads.

Participants are random words, and no dates leave the machine.
"""

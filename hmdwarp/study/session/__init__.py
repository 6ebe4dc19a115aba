"""Session: the steps of a study on the live loop, each stored before the next thing happens."""

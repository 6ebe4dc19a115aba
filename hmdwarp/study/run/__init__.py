"""A session through the live loop: shown, asked, and stored before the next thing happens."""

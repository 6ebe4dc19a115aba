"""Analysis of ratings: one long table, what it says, and its page and files."""

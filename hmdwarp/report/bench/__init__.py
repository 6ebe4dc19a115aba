"""The page, tables and charts of a bench."""

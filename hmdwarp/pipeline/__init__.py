"""The pipeline that every driver runs.

Options, sizes, the parts put together, and the loop over refreshes.
"""

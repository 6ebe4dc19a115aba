"""The pipeline that every driver runs: options, sizes, the parts put together, and the loop over refreshes."""

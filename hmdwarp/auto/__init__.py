"""Warp `auto`: quality levels and the governor that keeps a run within its time budget."""

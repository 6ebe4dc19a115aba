"""One RGB-D frame of the caller's own: no scene, no headset, one call."""

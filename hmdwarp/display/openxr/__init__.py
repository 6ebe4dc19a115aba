"""A headset through OpenXR."""

"""The compensator: makes the picture the eye should see now out of the newest late frame. Knows no window and no study."""

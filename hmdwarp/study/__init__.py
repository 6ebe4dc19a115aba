"""Rating studies: plans, sessions through the live loop, a crash-safe store, and statistics."""

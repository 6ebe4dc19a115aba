"""Rating studies: a plan in a file, sessions through the live loop, a store that loses nothing, and honest statistics."""

"""Responses with symbols: transforms, modes, impulses, jumps, and the conditions for their absence."""

"""Numbers with units in scenes. Read ``parameters``, then ``coordinates`` with their values, and ``variations``."""

"""Numbers with units in scenes. Read ``parameters``, then ``coordinates`` with their values; ``settings`` are values from the command line."""

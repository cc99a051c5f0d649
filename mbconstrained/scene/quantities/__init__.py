"""Numbers with units in scenes. Read ``parameters`` with ``expressions``, then ``coordinates`` with their
values; ``settings`` are values from the command line."""

"""Numbers with units. Read ``dimensions``, ``quantities``, then ``parameters`` with ``expressions``, then ``coordinates`` with their
values; ``settings`` are values from the command line."""

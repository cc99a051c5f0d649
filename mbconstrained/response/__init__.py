"""The pairs, values at 0- and a force become the response: a function of time, with its jumps and impulses."""

"""Response: a function of time, with jumps and impulses, from Jordan pairs, values at 0- and a force."""

"""Arrays in, arrays out: scaling, rank with its gap, staircase, block diagonal form, block exponentials."""

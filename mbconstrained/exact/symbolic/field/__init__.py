"""Numbers with symbols: rational functions, their factors, signs and roots."""

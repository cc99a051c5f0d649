"""The field of the entries: rational functions of symbols, their factors, signs, square roots and zeros."""

"""Polynomial matrices with symbols: determinants, Smith forms, Jordan chains and pairs, Laurent coefficients."""

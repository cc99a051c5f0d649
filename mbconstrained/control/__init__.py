"""Control: transfer functions, state spaces with or without descriptor.

It imports the mathematics below; nothing of mechanics, models or robots. Read in this order: transfer (one input and output,
fractions of polynomial matrices), state_equations, state_space with realization, conversions and poles_and_zeros, then
state_space_response.
"""

"""Control: transfer functions, state spaces with or without descriptor, and their mechanical normal form.

It imports mechanics and the mathematics below; nothing of models or robots. Read in this order: transfer (one input and output,
fractions of polynomial matrices), state_space with realization, conversions and poles_and_zeros, then
state_space_response and descriptor_form; normal_form at last.
"""

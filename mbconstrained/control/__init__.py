"""Control: transfer functions, state spaces with or without descriptor.

It imports the mathematics below; nothing of mechanics, models or robots. Read in this order: rational, transfer_function (one input and
output), then state_equations with poles and zeros, conversions, state_space; discrete_time has both in discrete time.
"""

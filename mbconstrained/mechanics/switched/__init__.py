"""Systems that change their equations: phases, guards, impacts and the motion through all of them.

Read in this order: flow (one phase over time and the first zeros of its guards), phase, switches, impact, sequence, switched_motion,
switched_system, periodic.
"""

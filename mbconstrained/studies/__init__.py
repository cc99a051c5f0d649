"""Studies of accuracy and stability: each takes a scene and returns tables, figures and data.

A study compares the answers of this package with exact arithmetic and with other tools. It imports every room below, the page
and the scene, but not the command line. Read ``study_problem`` and ``reference_solution``, then ``accuracy`` (error against run
time) and ``stability`` (correct digits for stiff and extreme systems); ``study_report`` writes the results.
"""

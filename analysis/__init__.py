"""The numeric room: cells, Filippov sets, equilibria, trajectories and error against run time.

It may import `nonsmooth.symbolic`, NumPy and SciPy; CVXPY only inside the call that needs it,
Matplotlib never. Its tolerances are named constants, each with a unit and a reason.
"""

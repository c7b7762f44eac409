"""The exact room: scenes, number fields, constraints Omega_i, contact states and governing equations.

Every number is an element of one real field per scene, every sign is certified, and no float or tolerance decides
anything.  It may import python-flint, pydantic and SymPy (SymPy only inside the call that needs it: numbers and
contact states do without), never SciPy, CVXPY or another room.  Text from a user goes through the whitelist of
`expression`, never through an evaluator.
"""

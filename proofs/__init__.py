"""The exact room again: inequality proofs, the clauses of Theorem 4, certificates, the stand-alone checker.

It may import `nonsmooth.symbolic` and `nonsmooth.analysis`: floats propose, exact arithmetic
disposes. It holds no tolerance, and missing evidence never passes.
"""

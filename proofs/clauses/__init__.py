"""The clauses of Theorem 4, one file each: equilibrium, translation, rotation, feedback, and what they rest on."""

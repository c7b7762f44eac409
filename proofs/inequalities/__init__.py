"""`prove(sense, polynomial, region)`: a proof, an exact witness, or undecided, in exact arithmetic alone."""

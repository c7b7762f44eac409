"""The kernel of proofs: claims of theorems, the search for their evidence, and certificates."""

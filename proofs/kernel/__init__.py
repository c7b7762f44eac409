"""The search for evidence of what the checker asks.  Nothing here is trusted; :mod:`nonsmooth.proofs.checker` is."""

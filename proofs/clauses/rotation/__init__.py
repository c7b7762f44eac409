"""Clause 3: stability of the heading theta."""

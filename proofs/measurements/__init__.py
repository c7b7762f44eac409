"""Measurements that compare verdicts, and the registry of all measurements."""

"""Trajectories of switched fields: event-driven and exact where the field allows it; hysteresis and batches."""

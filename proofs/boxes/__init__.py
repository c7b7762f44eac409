"""Arrays whose numbers are boxes: motions to first order, loads, forces and places of rest, for every member."""

"""Arrays of driven wheels under a body: friction sets, constraints, contact states, loads, governing equations."""

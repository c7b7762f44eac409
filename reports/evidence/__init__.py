"""Evidence from the world: predictions beside what others measured, shipped or published; nothing is fitted."""

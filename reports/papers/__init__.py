"""Papers, each in a folder named after its authors and year: what they print, against the computation."""

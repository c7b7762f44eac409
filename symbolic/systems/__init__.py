"""Plain systems: switched fields in states, and those that behave alike."""

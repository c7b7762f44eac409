"""Error against run time: one file for each study, with its reference, its methods and their settings."""

"""Error against run time: one file for each study, with its yardstick, its methods and their settings."""

"""One command of the command line per file; each imports what it needs inside, so that help stays light."""

"""The workbench: a local page on which an array is a thing in the hand, and the server behind it."""

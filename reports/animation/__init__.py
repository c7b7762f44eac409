"""A path as a moving picture: a film by Matplotlib's writer, and a page that needs no network."""

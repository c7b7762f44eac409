"""A path as a moving picture: a film by Matplotlib's writers, and a page that needs no network."""

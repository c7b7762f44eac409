"""The room for people: the command line, derivation reports and figures.

It may import every other room, and no other room imports it. Matplotlib and Jinja2 are imported
only inside the call that needs them.
"""

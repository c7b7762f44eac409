"""``python -m nonsmooth``: the command line."""

from nonsmooth.reports.cli import main

main()

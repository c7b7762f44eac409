"""Stand-alone checker of certificates: the standard library alone, and nothing of the workbench."""

from .files import check_file as check_file

"""Tables of results as data sets of xarray, with a dimension for each column that says where a row lies."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from typing import Any


def dataset(frame: Any, dimensions: Sequence[str]) -> Any:
    """A table as a Dataset.

    Args:
        frame: a data frame of pandas.
        dimensions: columns; where the rows are all combinations of their values, each once, they are the dimensions.
            Otherwise (starts at random, two rows at the time of a jump) there is one dimension, ``row``.

    Raises:
        ImportError: where xarray is not installed.
    """
    is_grid = prod(frame[name].nunique(dropna=False) for name in dimensions) == len(frame)
    if is_grid and not frame.duplicated(list(dimensions)).any():
        return frame.set_index(list(dimensions)).to_xarray()
    return frame.rename_axis("row").to_xarray()

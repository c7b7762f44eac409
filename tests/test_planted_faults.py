"""The list of faults to plant is about the product as it stands; ``python -m tests.planted_faults`` plants them."""

from __future__ import annotations

import pytest

from tests.planted_faults import ROOT, Fault, faults, places


@pytest.mark.parametrize("fault", faults(), ids=lambda fault: f"{fault.file}: {fault.wrong.splitlines()[0]}")
def test_a_fault_can_be_planted_where_the_list_says(fault: Fault) -> None:
    assert places(fault) == 1, f"required once, received {places(fault)} times: {fault.text}"
    assert fault.wrong != fault.text
    assert fault.rows or fault.tests
    assert all((ROOT / name.partition("::")[0]).exists() for name in fault.tests)

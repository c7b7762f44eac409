"""Every planted fault can be planted, and what should find it is there (`python -m tests.planted_faults`)."""

from __future__ import annotations

import pytest

from tests.golden.matrix import rows
from tests.planted_faults import ROOT, Fault, faults
from tests.thorough import thorough

TESTED = {row.line for row in rows() if row.tested}


@thorough
@pytest.mark.parametrize("fault", faults(), ids=lambda fault: f"{fault.file}: {fault.text.strip()}")
def test_a_fault_stands_at_one_place_and_is_looked_for(fault: Fault) -> None:
    assert (ROOT / fault.file).read_text(encoding="utf-8").count(fault.text) == 1
    assert fault.wrong != fault.text
    assert fault.found_by
    assert set(fault.rows) <= TESTED
    assert all((ROOT / test.partition("::")[0]).exists() for test in fault.tests)

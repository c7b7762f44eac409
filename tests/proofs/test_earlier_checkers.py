"""The checker of arrays of version 1, which shares no code with the new one, accepts what it has words for.

Plain systems have a second checker, written from the specification alone: :mod:`.test_second_checker`.
"""

from __future__ import annotations

import pytest

from tests.certificates.corpus import good_arrays
from tests.oracles.earlier_arrays import earlier_array, refusal_of_version_1
from tests.thorough import keep

WITHOUT_WORDS = {"array-omni-3-nearest", "array-mecanum-4-nearest"}  # rows without friction


def test_which_arrays_version_1_has_words_for() -> None:
    assert {name for name, own in good_arrays().items() if earlier_array(own) is None} == WITHOUT_WORDS


@pytest.mark.parametrize("start", keep(1, range(48)))
def test_arrays_of_the_corpus(start: int) -> None:
    words = {name: own for name, own in good_arrays().items() if name not in WITHOUT_WORDS}
    assert not [name for name in list(words)[start::48] if refusal_of_version_1(words[name])]

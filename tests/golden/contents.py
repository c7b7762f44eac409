"""What is in an output, as plain JSON of moderate length: text by lines, pictures and pages by what they hold."""

from __future__ import annotations

import csv
import hashlib
import json
import re
import struct
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

LONGEST_LIST = 24  # longer ones become their ends and sums
LONGEST_TEXT = 400  # lines; longer ones too
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
RUN_TIMES = {"seconds", "work"}  # left out of sums
VERSION = re.compile(r"\b(nonsmooth|Python|python-flint|sympy|numpy|scipy|matplotlib) \d+(?:\.\d+)+")
FRAME = "│┃"
RULES = set("╭╮╰╯├┤┬┴┼─━┏┓┗┛┡┩╇┳┻╈")


def content_of(path: Path) -> Any:
    """What a written file holds, by its ending."""
    data = path.read_bytes()
    match path.suffix:
        case ".png":
            width, height = struct.unpack(">II", data[16:24])
            return {"picture": data[:4].decode("latin-1")[1:], "size": [width, height]}
        case ".gif":
            return {"picture": data[:6].decode("latin-1"), "size": list(struct.unpack("<HH", data[6:10]))}
        case ".pdf" | ".mp4" | ".parquet" | ".db" | ".sqlite":
            return {"begins": data[:4].decode("latin-1"), "is empty": not data}
        case ".json":
            return _document(json.loads(data))
        case ".csv":
            return plain(list(csv.reader(data.decode().splitlines())))
        case ".svg" | ".html":
            return page(data.decode())
    return text_lines(data.decode())


def _document(document: Any) -> Any:
    """A JSON file; of a certificate what it is about, since its evidence may be another and `verify` judges it."""
    if isinstance(document, dict) and "certificate" in str(document.get("version")):
        theorems = [entry["theorem"] for entry in document["evidence"]]
        return {"theorems": theorems, **{key: document[key] for key in ("version", "statement", "notes")}}
    if isinstance(document, dict) and "certificate" in str(document.get("schema")):
        kept = ("schema", "states", "rhs", "at", "verdict", "theorem4", "rule", "notes")
        return {"keys": sorted(document), **{key: plain(document[key]) for key in kept if key in document}}
    return plain(document)


def plain(value: Any) -> Any:
    """A value as JSON, with long lists as their ends and sums."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, Sequence | set | frozenset) or hasattr(value, "__next__"):
        items = list(value)
        return _ends_and_sums(items) if len(items) > LONGEST_LIST else [plain(item) for item in items]
    return text_lines(str(value))


def _ends_and_sums(items: list[Any]) -> dict[str, Any]:
    """A long list: its length and ends, the mean and mean size of all numbers in it, and a digest of all texts."""
    numbers, texts = [], hashlib.sha256()
    for leaf in _leaves(items):
        if isinstance(leaf, str):
            words, found = split(leaf)
            texts.update("\0".join(words).encode())
            numbers += [float(number) for number in found if len(number) < 300]
        elif leaf is None or isinstance(leaf, bool):
            texts.update(str(leaf).encode())
        else:
            numbers.append(float(leaf))
    return {
        "length": len(items),
        "ends": [plain(item) for item in (*items[:3], *items[-2:])],
        **_sums(numbers),
        "texts": texts.hexdigest()[:10],
    }


def _sums(numbers: Sequence[float]) -> dict[str, Any]:
    count = max(1, len(numbers))
    return {
        "numbers": len(numbers),
        "mean": sum(numbers) / count,
        "mean size": sum(abs(number) for number in numbers) / count,
    }


def _leaves(value: Any) -> Iterable[Any]:
    if isinstance(value, Mapping):
        for key, entry in value.items():
            yield str(key)
            if key not in RUN_TIMES:
                yield from _leaves(entry)
    elif isinstance(value, list | tuple):
        for entry in value:
            yield from _leaves(entry)
    elif hasattr(value, "tolist"):
        yield from _leaves(value.tolist())
    else:
        yield value if value is None or isinstance(value, bool | int | float | str) else str(value)


def split(text: str) -> tuple[list[str], list[str]]:
    """The words around the numbers of a text, and these."""
    return NUMBER.split(text), NUMBER.findall(text)


def text_lines(text: str) -> Any:
    """Lines without the frames of tables, the padding of their cells, and the versions of this and other programs."""
    lines = []
    for line in VERSION.sub(r"\1 (version)", text).splitlines():
        stripped = line.strip()
        if stripped[:1] in FRAME and stripped[-1:] in FRAME and len(stripped) > 1:
            stripped = " | ".join(stripped[1:-1].split(stripped[0]))
        if stripped and not set(stripped) <= RULES:
            lines.append(" ".join(stripped.split()))
    return lines if len(lines) <= LONGEST_TEXT else _ends_and_sums(lines)


class _Page(HTMLParser):
    """The texts, tags and numbers of a page or a picture."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: Counter[str] = Counter()
        self.texts: list[str] = []
        self.numbers: list[float] = []
        self._hidden: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags[tag] += 1
        if tag in {"script", "style", "metadata", "title"}:
            self._hidden.append(tag)
        for name, value in attrs:
            if name in {"d", "points", "x", "y", "cx", "cy", "r", "width", "height"} and value:
                self.numbers += [float(number) for number in split(value)[1]]

    def handle_endtag(self, tag: str) -> None:
        if self._hidden and self._hidden[-1] == tag:
            self._hidden.pop()

    def handle_comment(self, data: str) -> None:
        """Matplotlib draws letters as shapes, and says in a comment which."""
        if "<" not in data:
            self.texts.append(" ".join(data.split()))

    def handle_data(self, data: str) -> None:
        if data.strip():
            words = " ".join(data.split())
            self.texts.append(f"({len(words)} characters)" if self._hidden else words)


def page(text: str) -> dict[str, Any]:
    """An .svg or .html file: its texts in order, how many elements of each kind, and the sums of its coordinates."""
    parser = _Page()
    parser.feed(VERSION.sub(r"\1 (version)", text))
    texts = [words for words in parser.texts if words]
    return {"texts": plain(texts), "tags": dict(sorted(parser.tags.items())), "coordinates": _sums(parser.numbers)}

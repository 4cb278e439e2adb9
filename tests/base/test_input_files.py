"""Texts and tables of users mean the same however their editor saved them; what could mean two things is refused."""

from __future__ import annotations

import os
import socket

import numpy as np
import pytest

from billow.base.input_file import LARGEST_TEXT, decoded, read_bytes, read_text
from billow.base.table_file import Table, read_table, whole_numbers
from billow.base.toml_file import DEEPEST_KEY, parse_toml

TEXT = "# Überdruck in µs\na = 1\nb = 2\n"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-32", "cp1252", "latin-1"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_a_text_is_the_same_in_every_encoding_and_with_every_end_of_line(encoding, end):
    assert decoded(TEXT.replace("\n", end).encode(encoding)) == TEXT
    assert parse_toml(decoded(TEXT.replace("\n", end).encode(encoding))) == {"a": 1, "b": 2}


def test_big_endian_text_with_a_byte_order_mark_is_read():
    assert decoded(b"\xfe\xff" + TEXT.encode("utf-16-be")) == TEXT
    assert decoded(b"\x00\x00\xfe\xff" + TEXT.encode("utf-32-be")) == TEXT


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"a = 1\n\0", "line 2 holds the control character 0x00"),
        (b"a\r\nb\r\n\x1b[31m", "line 3 holds the control character 0x1b"),
        ("a = 1\n".encode("utf-16-le"), "UTF-16 without a byte order mark"),
        (b"ok\n\x81\x8d", "line 2 holds bytes that stand for no letter"),
        (b"\xef\xbb\xbfa\n\xff", "line 2 is not UTF-8"),
        (b"\xff\xfea", "not UTF-16"),
    ],
)
def test_what_is_no_text_is_refused_with_its_line(content, told):
    with pytest.raises(ValueError, match=r"^[^{}]*$") as caught:
        decoded(content)
    assert told in str(caught.value)


def test_only_regular_files_of_a_bounded_size_are_opened(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    with socket.socket(socket.AF_UNIX) as one:
        one.bind("socket")  # paths of sockets are short
        for path, kind in (
            (tmp_path / "pipe", "a pipe"), (tmp_path / "socket", "a socket"), (tmp_path, "a folder"),
            ("/dev/zero", "a device"), ("/dev/full", "a device"), ("a\0b", "no file can have this path"),
        ):  # fmt: skip
            with pytest.raises(OSError, match=kind):
                read_bytes(path, 100)
    (tmp_path / "long").write_bytes(b" " * 101)
    with pytest.raises(OSError, match="101 bytes; at most 100"):
        read_bytes(tmp_path / "long", 100)
    with pytest.raises(FileNotFoundError):
        read_text(tmp_path / "none")


def test_a_file_that_hides_its_size_is_bounded_too():
    with pytest.raises(OSError, match="more than 10 bytes"):
        read_bytes("/proc/self/status", 10)  # says that it has none


SAME = [
    "x,y\n1.5,-2\n3e2,4\n",
    "x;y\n1.5;-2\n3e2;4\n",
    "x;y\n1,5;-2\n3e2;4\n",
    "x\ty\n1,5\t-2\n3e2\t4",
    "sep=;\nx;y\n1,5;-2\n3e2;4\n",
    "# of today\n\nx , y\n# below\n 1.5, -2 \n\n3e2,4\n\n",
    'x,y\n"1.5","-2"\n"3e2",4\n',
    "x,y,\n1.5,-2,\n3e2,4,\n,,\n",
]


@pytest.mark.parametrize("text", SAME)
def test_a_table_is_the_same_with_every_separator_and_decimal_mark(text):
    table = Table(text)
    assert table.names == ("x", "y")
    values, lines = table.numbers()
    assert values.tolist() == [[1.5, -2.0], [300.0, 4.0]]
    written = text.splitlines()
    assert [written[line - 1].strip(' "')[:1] for line in lines] == ["1", "3"]
    assert table.numbers(["y"])[0].tolist() == [[-2.0], [4.0]]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "it is empty"),
        ("\n \n# only this\n", "it is empty"),
        ("x,y\n1\n", "line 2 has 1 value, the header in line 1 names 2"),
        ("x,y\n1,5;2,5\n", "line 2 has 3 values"),
        ("x\n1,5\n", "line 2 has 2 values"),
        ("x;y\n1.5;2\n3;1,5\n", "line 2 has a decimal point, line 3 a decimal comma"),
        ("x;y\n1.234,5;2\n", "line 2 has a decimal point, line 2 a decimal comma"),
        ("x;y\n1,234,5;2\n", "is '1,234,5', not a number"),
        ("x,y\n1,\n", "line 2: the value of 'y' is missing"),
        ("x,y\n\n1,two\n", "line 3: the value of 'y' is 'two', not a number"),
        ("x,y\n1,1_0\n", "is '1_0', not a number"),
        ("x,y\n1,٣\n", "not a number"),
        ("x,y\n1,nan\n", "not a finite number"),
        ("x,y\n1,1e999\n", "line 2: the value of 'y' is not a finite number"),
        ('x,y\n1,"2\n', "line 2: a quotation mark"),
        ("x,x\n1,2\n", "line 1 names two columns 'x'"),
        ("x;y\n[ms];[kPa]\n1;2\n", "line 2: the value of 'x' is '[ms]', not a number"),
        ("," * 20_000, "names 0 columns"),
        (",".join(map(str, range(20_000))), "names 20000 columns"),
    ],
)
def test_what_a_table_could_mean_in_two_ways_is_refused_with_its_line(text, told):
    with pytest.raises(ValueError, match=r"^it|^line") as caught:
        Table(text).numbers()
    assert told in str(caught.value)


def test_plain_tables_are_read_like_all_others():
    rows = np.random.default_rng(3).normal(size=(200, 3)).tolist()
    text = "a,b,c\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows)
    fast, careful = Table(text).numbers(), Table(text.replace("\n", "\n# \n", 1)).numbers()
    assert fast[0].tolist() == careful[0].tolist() == rows
    assert (fast[1] + 1 == careful[1]).all()


def test_a_table_without_rows_is_told_and_missing_columns_are_named(tmp_path):
    (tmp_path / "t.csv").write_text("x,y\n\n# nothing\n")
    with pytest.raises(ValueError, match="names its columns and has no rows"):
        read_table(tmp_path / "t.csv")
    with pytest.raises(ValueError, match="its columns are x, y; z missing"):
        Table("x,y\n1,2").numbers(["x", "z"])
    assert np.isnan(Table("x\nnan\n-inf\n").numbers(finite=False)[0][0, 0])


def test_whole_numbers_are_never_rounded():
    assert whole_numbers(np.array([0.0, 3.0]), "node").tolist() == [0, 3]
    assert whole_numbers(np.array([2**40], ">i8"), "node").tolist() == [2**40]
    for value in (0.5, np.nan, np.inf, 1e16, -1e300):
        with pytest.raises(ValueError, match=r"node .* is not a whole number"):
            whole_numbers(np.array([1.0, value]), "node")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (".".join("a" * 20_000) + " = 1", f"line 1 has a key of more than {DEEPEST_KEY} parts"),
        ("x = 1\n[" + " . ".join(["'a b'"] * 50) + "]", "line 2 has a key"),
        ("x = {" + ".".join("a" * 50) + " = 1}", "line 1 has a key"),
        ("x = " + "[" * 100_000, "nested too deeply"),
        ("x = 1\ny = " + "9" * 5000, "line 2 has a number of more than"),
    ],
)
def test_toml_that_would_take_gigabytes_is_refused_at_once(text, told):
    assert len(text) < LARGEST_TEXT
    with pytest.raises(ValueError, match=r"line|nested") as caught:
        parse_toml(text)
    assert told in str(caught.value)


def test_comments_and_texts_may_have_any_number_of_dots():
    assert parse_toml("# " + ".".join("a" * 50) + "\nx = '" + ".".join("b" * 50) + "'")["x"].startswith("b.b")

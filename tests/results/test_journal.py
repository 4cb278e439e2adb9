import os
import signal
import subprocess
import sys

import numpy as np
import pytest

from billow.base.errors import IntegrityError
from billow.results.journal import Journal, frames, pieces, read_history

KILLED = """
import os, sys, numpy as np
from billow.results.journal import Journal
journal = Journal(sys.argv[1])
journal.columns(["time [s]", "load [N]"])
for k in range(5):
    journal.row(np.array([k, 2.0 * k]))
    journal.frame({"positions": np.full((3, 3), float(k))})
journal.sync()
journal.row(np.array([9.0, 9.0]))
os.kill(os.getpid(), 9)
"""


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "journal.bin"
    ended = subprocess.run([sys.executable, "-c", KILLED, str(path)], env=os.environ, check=False)
    assert ended.returncode == -signal.SIGKILL
    return path


def test_what_was_synced_survives_a_kill(path):
    np.testing.assert_array_equal(read_history(path)["load [N]"], 2.0 * np.arange(5))
    assert [frame["positions"][0, 0] for frame in frames(path)] == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_going_on_drops_what_lies_behind_the_offset(path):
    sizes = [1 + 8 + 32 + len(payload) for _, payload in pieces(path)]
    offset = sum(sizes[:5])  # columns and two pairs of row and frame
    journal = Journal(path, offset)
    journal.row(np.array([7.0, 70.0]))
    journal.close()
    np.testing.assert_array_equal(read_history(path)["time [s]"], [0.0, 1.0, 7.0])
    assert len(list(frames(path))) == 2


@pytest.mark.parametrize("cut", [-1, 20])
def test_a_piece_cut_short_is_noticed(path, cut):
    path.write_bytes(path.read_bytes()[:cut])
    with pytest.raises(IntegrityError, match="E-RES-030"):
        list(pieces(path))


def test_every_flipped_byte_of_a_payload_is_noticed(path):
    whole = path.read_bytes()
    for at in range(41, len(whole), 97):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :])
        with pytest.raises(IntegrityError, match="E-RES-030"):
            list(pieces(path))

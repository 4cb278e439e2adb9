"""Limits of decks: size, depth, number of files, cells, and folders that includes may lie in; of both formats."""

from __future__ import annotations

import pytest
from radioss_text import MORE, SMALL
from test_decks_of_others import Pillow

from billow.base.errors import InputError
from billow.decks import keyword_file
from billow.decks.import_deck import Options, import_deck
from billow.decks.radioss import starter_file
from billow.geometry import mesh_file

FORMATS = {
    "bag.k": (keyword_file, "*INCLUDE\n{}\n", Pillow().deck, "*NODE\n"),
    "bag_0000.rad": (starter_file, "#include {}\n", lambda: SMALL, "/NODE\n"),
}
"""File -> module of its limits, how it includes, a sound deck, and where an include may stand."""


@pytest.fixture(params=list(FORMATS))
def deck(request, tmp_path):
    """Import a deck with an include, and others of its kind: its error."""
    module, include, sound, before = FORMATS[request.param]
    folder = tmp_path / "deck"
    folder.mkdir()
    (folder / "more.inc").write_text(MORE)

    def make(name: str, **options) -> InputError:
        text = sound()
        (folder / request.param).write_text(text.replace(before, include.format(name) + before, 1))
        with pytest.raises(InputError) as error:
            import_deck(folder / request.param, tmp_path / "case", Options(**options))
        assert not (tmp_path / "case").exists()
        return error.value

    make.module, make.include, make.folder, make.begin = module, include, folder, before
    return make


def test_a_deck_that_is_too_large_and_one_that_becomes_so_by_its_includes(deck, monkeypatch):
    (deck.folder / "large.inc").write_text("$" * 20_000 + "\n" + deck.begin)
    monkeypatch.setattr(deck.module, "LARGEST_DATA", 20_000)
    assert (deck("large.inc").code, "large.inc" in str(deck("large.inc"))) == ("E-DCK-002", True)
    monkeypatch.setattr(deck.module, "LARGEST_DATA", 100)
    assert deck("large.inc").code in ("E-DCK-001", "E-DCK-160")


def test_includes_that_are_too_deep_or_too_many(deck, monkeypatch):
    for k in range(20):
        (deck.folder / f"deep{k}.inc").write_text(deck.include.format(f"deep{k + 1}.inc"))
    found = deck("deep0.inc")
    assert (found.code, "16 deep" in found.why) == ("E-DCK-002", True)
    (deck.folder / "many.inc").write_text(deck.begin + deck.include.format("more.inc") * 9)
    monkeypatch.setattr(deck.module, "MOST_FILES", 8)
    found = deck("many.inc")
    assert (found.code, "more than 8 of them" in found.why) == ("E-DCK-002", True)


@pytest.mark.parametrize("name", ["../outside.inc", "{absolute}", "link.inc", "folder/inside.inc"])
def test_files_outside_the_folder_are_refused_even_behind_a_link(deck, name):
    outside = deck.folder.parent / "outside.inc"
    outside.write_text(deck.begin)
    (deck.folder / "link.inc").symlink_to(outside)
    (deck.folder.parent / "other").mkdir()
    (deck.folder.parent / "other" / "inside.inc").write_text(deck.begin)
    (deck.folder / "folder").symlink_to(deck.folder.parent / "other")
    found = deck(name.format(absolute=outside))
    assert (found.code, "outside the deck's folder" in found.why) == ("E-DCK-002", True)


def test_a_bag_of_too_many_cells(deck, monkeypatch):
    monkeypatch.setattr(mesh_file, "MOST_CELLS", 3)
    (deck.folder / "nothing.inc").write_text(deck.begin)
    found = deck("nothing.inc", units="kg-mm-ms", parts={1: "fabric", 2: "fabric", 3: "fabric"})
    assert (found.code, "at most 3 are allowed" in found.why) == ("E-DCK-012", True)

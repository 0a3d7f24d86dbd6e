# SPDX-License-Identifier: MIT
"""Words that are taken until 1.0: each call does what it did, and a warning names the new word."""
import pickle
import warnings

import dermis
import pytest
from dermis import contact

GRID = {"grid": {"width": 9, "height": 8}}


def test_n_is_the_number_of_pads_and_the_warning_names_count_at_the_callers_line():
    for n in (3, (2, 3)):
        with pytest.warns(DeprecationWarning, match=r"Skin\(n=\.\.\) is called Skin\(count=\.\.\)") as caught:
            old = dermis.Skin(GRID, n=n)
        assert caught[0].filename == __file__
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            new = dermis.Skin(GRID, count=n)
            assert pickle.loads(pickle.dumps(old))["sa1"].shape == new["sa1"].shape == dermis.Skin(GRID, n)["sa1"].shape
            new.load(old.save())
    with pytest.warns(DeprecationWarning), pytest.raises(dermis.InputError, match="n = 2; allowed: none beside count"):
        dermis.Skin(GRID, 2, n=2)


def test_class_is_the_type_of_fibres_and_the_warning_names_type(tmp_path):
    text = "[grid]\nwidth = 9\nheight = 8\n[[afferents]]\nclass = 'fa1'\ncells = [[3, 4]]\n"
    (tmp_path / "old.toml").write_text(text)
    tables = GRID | {"afferents": [{"class": "fa1", "cells": [[3, 4]]}]}
    new = dermis.Scene(GRID, afferents=[{"type": "fa1", "cells": [[3, 4]]}])
    for read in (lambda: dermis.Scene(tables), lambda: dermis.Scene.from_string(text), lambda: dermis.Skin(tables).scene,
                 lambda: dermis.Scene.from_file(tmp_path / "old.toml")):
        with pytest.warns(FutureWarning, match="afferents.class is called afferents.type; class is read until 1.0"):
            assert read() == new
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(FutureWarning):
            dermis.Scene(tables)
        dermis.Scene.from_string(new.to_toml())


@pytest.mark.parametrize("old, new", [("Report", "ContactReport"), ("depths_of", "fill_depths")])
def test_an_old_name_of_contacts_is_the_new_one_and_warns(old, new):
    with pytest.warns(DeprecationWarning, match=f"contact.{old} is contact.{new}"):
        assert getattr(contact, old) is getattr(contact, new)

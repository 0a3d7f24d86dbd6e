# SPDX-License-Identifier: MIT
"""Contacts to pressure, in an array of the caller's."""
import threading

import dermis
import numpy as np
import pytest
from dermis import contact

SPACING = 2.5e-4
PATCH = dict(x=0.01, y=0.008, force=0.5, radius=0.003)


def force_in(pressure):
    return pressure.sum(dtype=float) * SPACING**2


def test_a_force_is_kept_and_reported():
    pressure = np.zeros((64, 80), np.float32)
    report = contact.add_contacts(contact.Pad(pressure, SPACING), [contact.Contact(**PATCH)])
    assert force_in(pressure) == pytest.approx(0.5, rel=1e-6) and report.placed == pytest.approx(0.5)
    assert report.plausible and report.doubts == "" and report.cells == np.count_nonzero(pressure)
    y, x = np.unravel_index(pressure.argmax(), pressure.shape)
    assert abs(x - 40) <= 1 and abs(y - 32) <= 1


def test_pressure_is_added_to_a_part_of_an_array():
    whole = np.zeros((100, 200), np.float32)
    part = whole[10:74, 50:130]
    pad = contact.Pad(part, SPACING)
    for _ in range(2):
        contact.add_contacts(pad, [contact.Contact(**PATCH)])
    assert force_in(whole) == pytest.approx(1.0, rel=1e-6) and not whole[:, :50].any() and not whole[:10].any()


def test_contacts_of_the_world_are_at_the_foot_of_their_perpendicular():
    pressure, moved = (np.zeros((64, 80), np.float32) for _ in range(2))
    contact.add_contacts(contact.Pad(pressure, SPACING), [contact.Contact(**PATCH)])
    pose = contact.Pose.from_quaternion([1.0, 2.0, 3.0], [1.0, 0.0, 0.0, 0.0])
    patch = contact.WorldContact(position=(1.01, 2.008, 3.001), force=0.5, radius=0.003)
    report = contact.add_contacts(contact.Pad(moved, SPACING), pose, 0.002, [patch])
    assert report.placed == pytest.approx(0.5)
    np.testing.assert_allclose(moved, pressure, rtol=1e-3, atol=1)


def test_depths_share_a_force():
    depth = np.zeros((64, 80), np.float32)
    depth[30:34, 40:44] = 1e-3
    pressure = np.zeros((64, 80), np.float32)
    report = contact.add_depths(contact.Pad(pressure, SPACING), depth, force=1.0)
    assert report.placed == pytest.approx(1.0) and np.count_nonzero(pressure) == 16


def test_a_contact_that_is_refused_is_named_and_nothing_happens():
    pressure = np.zeros((4, 5), np.float32)
    with pytest.raises(dermis.Error) as caught:
        contact.add_contacts(contact.Pad(pressure, SPACING), [contact.Contact(x=0, y=0, force=1),
                                                              contact.Contact(x=0, y=0, force=-1)])
    assert (caught.value.code, caught.value.parameter) == ("bad_input", "contacts[1].force")
    assert not pressure.any()
    with pytest.raises(dermis.Error, match="^ball = 0"):
        contact.hertz_radius(1.0, 0.0, 1e5)
    assert contact.hertz_radius(1.0, 0.01, 1e5) == pytest.approx((3 * 1.0 * 0.01 / 4e5) ** (1 / 3))
    assert contact.strain_below_punch(1e-3, 0.0, 5e-4) == pytest.approx(1e-3 / (np.pi * 5e-4 * 0.84))
    for arguments, name in (((np.nan, 0, 1), "indentation"), ((1, -1, 1), "depth"), ((1, 0, 0), "radius"), ((1, 0, 1, 0.6), "poisson")):
        with pytest.raises(dermis.InputError, match=name):
            contact.strain_below_punch(*arguments)


def test_taxels_share_their_force_with_the_cells_below():
    values = np.arange(12, dtype=np.float32).reshape(3, 4)  # four columns along x
    size = dict(width=16 * SPACING, height=16 * SPACING)
    row_by_row, column_by_column = (np.zeros((64, 80), np.float32) for _ in range(2))
    report = contact.add_taxels(contact.Pad(row_by_row, SPACING), values, **size)
    assert report.placed == pytest.approx(66) and force_in(row_by_row) == pytest.approx(66, rel=1e-6)
    assert row_by_row[40, 20] * 256 * SPACING**2 == pytest.approx(9)  # row 2, column 1
    stored = np.ascontiguousarray(values.T)
    contact.add_taxels(contact.Pad(column_by_column, SPACING), stored.T, **size)
    np.testing.assert_array_equal(column_by_column, row_by_row)
    pascal = np.zeros((64, 80), np.float32)
    contact.add_taxels(contact.Pad(pascal, SPACING), values, **size, x=16 * SPACING, unit="pascal")
    assert pascal[40, 36] == 9 and not pascal[:, :16].any()


def test_a_round_fingertip_is_pressed_where_it_is_touched():
    radius, angle = 8e-3, np.radians(62)
    place = np.array([80 * SPACING / 2 + radius * np.sin(angle), 80 * SPACING / 2, radius * (np.cos(angle) - 1)])
    touch = contact.WorldContact(position=place, force=1.0, radius=1e-3, direction=(-np.sin(angle), 0, -np.cos(angle)))
    flat, ball = np.zeros((80, 80), np.float32), np.zeros((80, 80), np.float32)
    assert not contact.add_contacts(contact.Pad(flat, SPACING), contact.Pose(), 5e-3, [touch]).plausible
    pad = contact.Pad(ball, SPACING, radius_x=radius, radius_y=radius)
    report = contact.add_contacts(pad, contact.Pose(), 1e-3, [touch])
    assert report.plausible and report.placed == pytest.approx(1, rel=1e-6)
    x = (np.arange(80) + 0.5 - 40) * SPACING
    assert (ball.sum(0) * x).sum() / ball.sum() == pytest.approx(radius * angle, abs=0.1 * SPACING)


def test_tiled_pads_share_a_patch():
    left, right = (contact.Pad(np.zeros((64, 40), np.float32), SPACING, tiled=True) for _ in range(2))
    alone = contact.Pad(np.zeros((64, 40), np.float32), SPACING)
    of_left, of_right, of_one = (contact.add_contacts(pad, [contact.Contact(x=x, y=0.008, force=0.5, radius=3e-3)])
                                 for pad, x in ((left, 0.01), (right, 0.0), (alone, 0.01)))
    assert of_left.plausible and of_right.plausible and of_left.outside == of_right.outside == 0
    assert of_left.asked + of_right.asked == pytest.approx(0.5) and "over the border" in of_one.doubts


@pytest.mark.parametrize("shape, named", [((0, 4), "taxels.rows = 0"), ((4, 0), "taxels.columns = 0")])
def test_arrays_without_numbers_add_nothing_or_are_refused_by_their_number(shape, named):
    pressure = np.zeros((64, 80), np.float32)
    pad = contact.Pad(pressure, SPACING)
    assert contact.add_contacts(pad, []).asked == 0 and contact.add_contacts(pad, np.array([])).asked == 0
    with pytest.raises(dermis.Error, match=named):
        contact.add_taxels(pad, np.zeros(shape, np.float32), width=1e-3, height=1e-3)
    with pytest.raises(dermis.Error, match="pad.height = 0"):
        contact.add_contacts(contact.Pad(pressure[:0], SPACING), [])
    assert not pressure.any()


@pytest.mark.parametrize("form", [lambda x: x[None, :], lambda x: x[:, None].T, lambda x: x[None, :][::-1],
                                  lambda x: np.stack([x, x])[::-1][:1], lambda x: np.stack([x, x])[1:]])
def test_one_row_of_numbers_or_one_column_presses_however_numpy_has_made_it(form):
    one = form(np.arange(16, dtype=np.float32))
    for turned in False, True:
        values = one.T if turned else one
        dense = np.ascontiguousarray(values)
        alike = [np.zeros(values.shape, np.float32) for _ in range(2)]
        for pressure, given in zip(alike, (values, dense)):
            contact.add_taxels(contact.Pad(pressure, 1e-3), given, width=1e-3, height=1e-3)
            if values.strides[-1] == 4 or values.shape[-1] == 1:
                contact.add_depths(contact.Pad(pressure, 1e-3), given, 1.0)
        assert alike[0].any() and (alike[0] == alike[1]).all()


def test_taxels_that_another_thread_changes_press_only_what_was_checked():
    pressure, values, ended = np.zeros((400, 400), np.float32), np.ones((400, 400), np.float32), threading.Event()

    def change():
        while not ended.wait(0.0007):
            values[200:, 5] = np.nan
            ended.wait(0.0007)
            values[200:, 5] = 1

    thread = threading.Thread(target=change)
    thread.start()
    try:
        for _ in range(60):
            try:
                contact.add_taxels(contact.Pad(pressure, 1e-3), values, width=1e-3, height=1e-3)
            except dermis.Error as error:
                assert "nan; allowed: a finite number >= 0" in str(error)
            assert np.isfinite(pressure).all()
    finally:
        ended.set()
        thread.join()

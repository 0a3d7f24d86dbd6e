# SPDX-License-Identifier: MIT
"""Contacts of a whole batch in one call, from NumPy's arrays."""
import itertools
import threading

import numpy as np
import pytest

import dermis
from dermis import contact

N, SIDE, CELL, RADIUS = 5, 48, 2.5e-4, 8e-3


def skin(**options):
    scene = dermis.fingertip(grid={"width": SIDE, "height": SIDE, "spacing": CELL}, surface={"kind": "flat"})
    return dermis.Skin(scene, count=N, **options)


@pytest.fixture
def hand():
    """A skin of five pads, and a table of contacts with unused rows, as a sensor gives it."""
    rng = np.random.default_rng(1)
    table = np.zeros((2 * N, 10))  # a flag, force, position, and what else a sensor has
    xy = rng.uniform(-2e-3, 2e-3, (2 * N, 2))
    z = np.sqrt(RADIUS**2 - (xy**2).sum(1)) - RADIUS
    table[:, 4:7] = np.c_[xy, z] + np.repeat(np.c_[np.arange(N) / 10, np.zeros((N, 2))], 2, 0)
    table[::2, 1:4] = [0.02, 0, -0.1]
    made = skin()
    touch = contact.Touch(made, reach=1e-3, radius_x=RADIUS, radius_y=RADIUS)
    middles = np.c_[np.arange(N) / 10, np.zeros((N, 2))]
    return made, touch, middles, np.tile(np.eye(3), (N, 1, 1)), np.repeat(np.arange(N), 2), table


def test_a_table_in_one_call_presses_as_contact_by_contact(hand):
    made, touch, middles, axes, pad, table = hand
    report = touch.add(middles, axes, pad, table[:, 4:7], table[:, 1:4], radius=2 * CELL)
    assert report.plausible, report.doubts
    alone = np.zeros((N, SIDE, SIDE), np.float32)
    placed, shear = 0, 0
    for i in range(0, 2 * N, 2):
        own = contact.Pad(alone[pad[i]], CELL, radius_x=RADIUS, radius_y=RADIUS)
        pose = contact.Pose(middles[pad[i]], axes[pad[i]]).from_middle(own)
        force = table[i, 1:4]
        one = contact.add_contacts(own, pose, 1e-3, [contact.WorldContact(
            position=table[i, 4:7], force=np.linalg.norm(force), radius=2 * CELL, direction=force)])
        placed, shear = placed + one.placed, shear + one.shear[0]
    np.testing.assert_allclose(touch.pressure, alone, rtol=1e-6)
    assert report.placed == pytest.approx(placed, rel=1e-9) and report.shear[0] == pytest.approx(shear, rel=1e-9)
    assert touch.report(3).asked == pytest.approx(np.linalg.norm(table[6, 1:4]))
    made.press(touch, 1e-3)
    other = skin()
    other.press(touch.pressure, 1e-3)
    assert (made["sa1"] == other["sa1"]).all() and made["sa1"].any()


def test_an_empty_call_takes_all_away_and_views_stay_valid(hand):
    _, touch, middles, axes, pad, table = hand
    pressure = touch.pressure
    touch.add(middles, axes.reshape(N, 9), pad.astype(np.int32), table[:, 4:7], table[:, 1:4], ball=RADIUS, modulus=1e5)
    assert pressure.any()
    none = np.zeros((0, 3))
    assert touch.add(middles, axes, np.zeros(0, int), none, none, radius=1e-3).asked == 0
    assert not pressure.any()
    for sizes in {"radius": []}, {"ball": [], "modulus": 1e5}, {"body": [], "shapes": contact.Shapes(*[[]] * 7)}:
        assert touch.add(middles, axes, [], [], [], **sizes).asked == 0


def test_axes_of_pads_and_of_contacts_may_be_several(hand):
    made, touch, middles, axes, pad, table = hand
    once = touch.add(middles, axes, pad, table[:, 4:7], table[:, 1:4], radius=np.full(2 * N, 1e-3))
    grouped = table.reshape(N, 2, 10)
    again = touch.add(middles, axes, pad.reshape(N, 2), grouped[..., 4:7], grouped[..., 1:4], radius=1e-3)
    assert once.placed == again.placed


@pytest.mark.parametrize("change", [
    lambda name, x: x.tolist(), lambda name, x: x.astype(">u8" if name == "pad" else ">f8"), lambda name, x: x.astype(np.uint8 if name == "pad" else np.float32),
    lambda name, x: np.asfortranarray(x), lambda name, x: x[::1] if x.ndim == 1 else np.repeat(x, 2, -1)[..., ::2]])
def test_numbers_of_any_type_and_order_press_as_float64(hand, change):
    _, touch, middles, axes, pad, table = hand
    given = dict(middle=middles, rotation=axes, pad=pad, position=np.round(table[:, 4:7] * 2**20) / 2**20,
                 force=np.round(table[:, 1:4] * 2**20) / 2**20)  # exact in float32
    given["middle"] = np.round(middles * 2**20) / 2**20
    touch.add(**given, radius=1e-3)
    expected = touch.pressure.copy()
    touch.add(**{name: change(name, np.asarray(x)) for name, x in given.items()}, radius=1e-3)
    assert expected.any() and (touch.pressure == expected).all()


def box_below_a_finger(**change):
    return contact.Shapes(**{**dict(pad=[0], body=[7], kind=[contact.KINDS["box"]], size=[[0.02, 0.02, 0.01]],
                                    position=[[0.02, 0, 0.01]], rotation=[np.eye(3)]), **change})


def pressed_by(shapes, **change):
    scene = dermis.fingertip(grid={"width": 16, "height": 16, "spacing": 1.5e-3}, surface={"kind": "flat"})
    touch = contact.Touch(dermis.Skin(scene), reach=1e-3)
    call = dict(middle=np.zeros((1, 3)), rotation=[np.eye(3)], pad=[0, 0], body=[7, 7], shapes=shapes,
                position=[[0, -0.012, 0], [0.012, 0.012, 0]], force=[[0, 0, -1], [0, 0, -1]])
    return touch.add(**{**call, **change}), touch


def test_the_whole_force_of_a_box_half_below_a_finger_presses_the_half_that_is_below():
    report, touch = pressed_by(box_below_a_finger())
    assert (report.by_body, report.by_patch, report.tilted) == (1, 0, 0)
    assert report.placed == pytest.approx(2, rel=1e-6) and report.plausible
    assert not touch.pressure[0, :, :8].any() and (touch.pressure[0, :, 8:] > 0).all()
    faces = np.r_[np.eye(3), -np.eye(3)]
    hull = box_below_a_finger(kind=[contact.KINDS["hull"]], size=[[6, 0, 0]],
                              faces=np.c_[faces, [0.02, 0.02, 0.01] * 2])
    _, other = pressed_by(hull)
    np.testing.assert_allclose(other.pressure, touch.pressure, rtol=1e-6)
    # The second contact's force in the place of the first, and the moment that this takes away.
    _, other = pressed_by(box_below_a_finger(), position=[[0, -0.012, 0], [0, -0.012, 0]],
                          force=[[0, 0, -1, 0, 0, 0], [0, 0, -1, -0.024, 0.012, 0]])
    np.testing.assert_allclose(other.pressure, touch.pressure, rtol=1e-5)


def test_depth_images_press_with_their_forces_and_say_where_they_stop_too_early():
    side, spacing = 16, 1.5e-3
    scene = dermis.fingertip(grid={"width": side, "height": side, "spacing": spacing}, surface={"kind": "flat"})
    touch = contact.Touch(dermis.Skin(scene, count=(2, 2)), reach=1e-3, stiffness=5e7, shear=True)
    x = (np.arange(side) + 0.5 - side / 2) * spacing
    ball = 15e-3 - np.hypot(x, x[:, None])**2 / 30e-3 - 15e-3 + 2e-5  # sunk by 20 um
    depth = np.broadcast_to(ball, (2, 2, side, side)).astype(np.float32)
    force = np.array([[[0.1, 0, -2], [0, 0, -1]], [[0, 0, 0], [0, 0, 1]]])  # a pad at rest, and one that is pulled
    report = touch.add_depths(depth, force, gaps=True)
    assert report.clipped == 0 and report.turned_away == 1 and report.shear[0] == pytest.approx(0.1, rel=1e-6)
    area = spacing**2
    np.testing.assert_allclose(touch.pressure.sum((1, 2)) * area, [2, 1, 0, 0], rtol=1e-6)
    # The foundation's law for a ball: F = pi*k*R*d^2, peak 2F/(pi*radius^2).
    sunk = np.sqrt(2 / (np.pi * 5e7 * 15e-3))
    assert touch.pressure[0].max() == pytest.approx(5e7 * sunk, rel=0.05)
    assert touch.report(0).level == pytest.approx(2e-5 - sunk, rel=0.02)
    clipped = touch.add_depths(np.maximum(depth + np.float32(8e-5), 0), force, gaps=False)
    assert clipped.clipped == 2 and "depth images have too few depths above 0" in clipped.doubts
    assert touch.pressure[0].max() > 2 * 5e7 * sunk  # on too few cells
    deeper = touch.add_depths(np.maximum(depth + np.float32(1e-3), 0), force, gaps=False)
    assert deeper.clipped == 0 and touch.pressure[0].max() == pytest.approx(5e7 * sunk, rel=0.05)
    for change, words in [({"depth": depth[0].copy()}, "depth = float32 array of shape (2, 16, 16); allowed: numbers of shape"),
                          ({"depth": np.full_like(depth, np.nan)}, "images.depth[0] = nan; allowed: -1e6..1e6"),
                          ({"force": force[0]}, "force = 2 of them; allowed: 4, one for each pad")]:
        with pytest.raises(dermis.Error) as refused:
            touch.add_depths(**{**dict(depth=depth, force=force, gaps=True), **change})
        assert str(refused.value).startswith(words), refused.value


def cylinder_at(x, radius=15e-3):
    """A cylinder along y that touches the pad's plane at x, as a Shapes of one."""
    return contact.Shapes(pad=[0], body=[0], kind=[contact.KINDS["cylinder"]], size=[[radius, 0.04, 0]],
                          position=[[x, 0, radius]], rotation=[[[1, 0, 0], [0, 0, 1], [0, -1, 0]]])


def test_a_skin_that_is_held_long_takes_the_shape_of_what_presses_it():
    side, spacing = 48, 5e-4
    scene = dermis.fingertip(grid={"width": side, "height": side, "spacing": spacing}, surface={"kind": "flat"})
    skin = dermis.Skin(scene)
    touch = contact.Touch(skin, reach=1e-3, stiffness=contact.skin_stiffness(scene))
    x = (np.arange(side) + 0.5 - side / 2) * spacing
    depth = np.float32(-np.hypot(x, x[:, None])**2 / 30e-3)
    touch.add_depths(depth, [0, 0, -1.0], gaps=True)
    level = touch.report(0).level
    skin.press(touch, 2000.0)
    assert skin.report().indentation.value == pytest.approx(depth.max() - level, rel=1e-3)
    assert touch.pressure.max() == pytest.approx(contact.skin_stiffness(scene) * (depth.max() - level), rel=1e-4)


def test_a_bottle_that_rolls_over_the_border_chatters_less_by_its_shape_than_by_patches():
    side, spacing, force = 16, 1.5e-3, 2.0
    scene = dermis.fingertip(grid={"width": side, "height": side, "spacing": spacing}, surface={"kind": "flat"})
    felt = {}
    for way in ("shapes", "patches"):
        skin = dermis.Skin(scene, responses=["fa2"])
        touch = contact.Touch(skin, reach=1e-3)
        energy = 0
        for n in range(700):
            x = 6e-3 + 1e-5 * n  # from inside to 1 mm beyond the border at 12 mm
            ends = np.array([[min(x, 12e-3), y, 0] for y in (-12e-3, 12e-3)])
            call = dict(middle=np.zeros((1, 3)), rotation=[np.eye(3)], pad=[0, 0], position=ends,
                        force=[[0, 0, -force / 2]] * 2)
            if way == "shapes":
                report = touch.add(**call, body=[0, 0], shapes=cylinder_at(x))
                assert report.placed == pytest.approx(force, rel=1e-6)
                skin.press(touch, 1e-3)
            else:
                report = touch.add(**call, ball=15e-3, modulus=1e5)
                skin.press(touch.pressure[0] * np.float32(force / report.placed), 1e-3)
            if n > 20:
                energy += float((skin["fa2"].astype(float)**2).sum())
        felt[way] = energy
    assert felt["shapes"] <= 0.3 * felt["patches"]


@pytest.mark.parametrize("change, words", [
    ({"kind": [9]}, "shapes.kind[0] = 9; allowed: sphere, capsule, box, plane, cylinder, ellipsoid, hull (0..6)"),
    ({"size": [[0.02, 0, 0.01]]}, "shapes.size[0][1] = 0; allowed: above 0"),
    ({"pad": [1]}, "shapes.pad[0] = 1; allowed: 0..0"), ({"body": [-1]}, "shapes.body[0] = -1; allowed: 0"),
    ({"kind": [6], "size": [[6, 1, 0]], "faces": np.zeros((6, 4))}, "shapes.size[0] = 6, 1, 0; allowed: of a hull"),
    ({"kind": [6], "size": [[6, 0, 0]], "faces": np.zeros((6, 4))}, "shapes.faces[0][0] = 0, 0, 0, 0; allowed: a normal"),
    ({"position": [[0, 0, 0]] * 2}, "shapes.position = 2 of them; allowed: 1, one for each shape"),
    ({"rotation": [2 * np.eye(3)]}, "shapes.rotation[0] = 2; allowed: -1.001..1.001")])
def test_a_shape_that_is_wrong_is_refused_by_name(change, words):
    with pytest.raises(dermis.Error) as refused:
        pressed_by(box_below_a_finger(**change))
    assert str(refused.value).startswith(words), refused.value


@pytest.mark.parametrize("change, words", [
    ({"pad": np.zeros(10)}, "pad = float64 array of shape (10,); allowed: whole numbers"),
    ({"position": np.zeros((10, 2))}, "position = float64 array of shape (10, 2); allowed: numbers of shape (..., 3)"),
    ({"force": np.zeros((9, 3))}, "force = 9 of them; allowed: 10, one for each contact"),
    ({"middle": np.zeros((4, 3))}, "middle = 4 of them; allowed: 5, one for each pad"),
    ({"rotation": np.zeros((5, 3, 2))}, "rotation = float64 array of shape (5, 3, 2); allowed: numbers of shape (..., 3, 3) or (..., 9)"),
    ({"force": [[0, 0, 1], [1]]}, "force = [[0, 0, 1], [1]]; allowed: numbers of shape (..., 3) or (..., 6)"),
    ({"radius": None}, "radius = None; allowed: m, of the patches; or ball and modulus; or body, with shapes"),
    ({"pad": np.full(10, 2**40)}, "pad = 1099511627776; allowed: whole numbers of 32 bits"),
    ({"pad": np.full(10, 2**64 - 1, np.uint64)}, "pad = 18446744073709551615; allowed: whole numbers of 32 bits"),
    ({"body": np.full(10, 2**64 - 1, ">u8")}, "body = 18446744073709551615; allowed: whole numbers of 32 bits"),
    ({"position": np.zeros((10, 3), str)}, "position = "),
    ({"radius": np.ones(3)}, "radius = 3 of them; allowed: 10, one for each contact"),
    ({"position": None}, "position = None"),
])
def test_what_no_touch_takes_is_refused_by_name(hand, change, words):
    _, touch, middles, axes, pad, table = hand
    call = dict(middle=middles, rotation=axes, pad=pad, position=table[:, 4:7], force=table[:, 1:4], radius=1e-3)
    with pytest.raises(dermis.Error) as refused:
        touch.add(**{**call, **change})
    assert str(refused.value).startswith(words), refused.value


def test_a_skin_takes_no_touch_of_other_pads_and_no_list_beside_it(hand):
    made, touch, *_ = hand
    for call, words in [(lambda: made.press(touch, 1e-3, pads=[0]), "pads = [0]"),
                        (lambda: made.press(touch, [1e-3] * 5), "dt = [0.001"),
                        (lambda: dermis.Skin({}).press(touch, 1e-3), "touch = 5 pads"),
                        (lambda: contact.Touch(dermis.Skin({}), 1e-3), "skin = <Skin"),
                        (lambda: contact.Touch(made, 9e-3, radius_x=8e-3), "reach = 0.009")]:
        with pytest.raises(dermis.Error) as refused:
            call()
        assert str(refused.value).startswith(words), refused.value


def test_a_skin_with_shear_takes_tractions_or_a_touch_with_its_own(hand):
    _, _, middles, axes, pad, table = hand
    made, other = skin(shear=True), skin(shear=True)
    touch = contact.Touch(made, reach=1e-3, radius_x=RADIUS, radius_y=RADIUS, shear=True)
    report = touch.add(middles, axes, pad, table[:, 4:7], table[:, 1:4], radius=1e-3)
    assert touch.traction.shape == (2, N, SIDE, SIDE)
    assert touch.traction[0].sum(dtype=float) * CELL**2 == pytest.approx(report.shear[0], rel=1e-6)
    made.press(touch, 1e-3)
    other.press(touch.pressure, 1e-3, traction=touch.traction)
    assert (made["shear_x"] == other["shear_x"]).all() and made["shear_x"].max() > 0
    assert made["stretch_xy"].shape == (N, SIDE, SIDE) and made["stretch_x"].any()
    ruffini = skin(shear=True, sa2_stretch=(1, 0))
    ruffini.press(touch, 1e-3)
    assert ruffini["sa2"].min() < 0 < ruffini["sa2"].max() and (ruffini["sa1"] == made["sa1"]).all()
    again = dermis.Skin(made.scene, count=N, shear=True)
    again.load(made.save())
    again.press(touch, 1e-3), made.press(touch, 1e-3)
    assert (again["shear_y"] == made["shear_y"]).all()
    for call, words in [(lambda: made.press(touch.pressure, 1e-3), "traction = (not given)"),
                        (lambda: made.press(touch.pressure, 1e-3, traction=touch.pressure), "traction = float32 array"),
                        (lambda: made.press(touch, 1e-3, traction=touch.traction), "traction = float32 array"),
                        (lambda: skin().press(touch, 1e-3), "traction = (given)"),
                        (lambda: skin(shear=True, sa2_stretch=[1]), "sa2_stretch = 1 numbers"),
                        (lambda: skin(sa2_stretch=(1, 0)), "sa2_stretch = (given)"),
                        (lambda: skin()["shear_x"], "response = 'shear_x'")]:
        with pytest.raises(dermis.Error) as refused:
            call()
        assert str(refused.value).startswith(words), refused.value


def test_a_ball_on_a_pad_has_hertz_radius_by_depths_of_its_shape():
    pressure = np.zeros((96, 96), np.float32)
    pad = contact.Pad(pressure, 1e-4)
    ball = contact.Body("sphere", [8e-3], position=(0, 0, 7.99e-3))
    depth = contact.fill_depths(pad, contact.Pose().from_middle(pad), ball)
    assert depth.shape == (96, 96) and depth.dtype == np.float32 and depth.max() == pytest.approx(1e-5, abs=4e-7)
    stiffness = contact.foundation_stiffness(0.5, 8e-3, 1e5)
    report = contact.add_depths(pad, depth, 0.5, stiffness)
    assert report.plausible and report.placed == pytest.approx(0.5, rel=1e-6)
    assert np.sqrt(report.cells * 1e-8 / np.pi) == pytest.approx(contact.hertz_radius(0.5, 8e-3, 1e5), rel=0.02)


@pytest.mark.parametrize("call, words", [
    (lambda p: contact.Body("ball", [1]), 'kind = "ball"; allowed: "sphere", "capsule", "box", "plane"'),
    (lambda p: contact.Body("box", [1, 2, 3, 4]), "size = 4 numbers; allowed: at most three numbers"),
    (lambda p: contact.fill_depths(p, contact.Pose(), contact.Body("capsule", [1])), "body.size[1] = 0; allowed: above 0"),
    (lambda p: contact.fill_depths(p, contact.Pose(), contact.Body("plane", [1])), "body.size[0] = 1; allowed: 0"),
    (lambda p: contact.fill_depths(p, contact.Pose(), "ball"), "body = 'ball'; allowed: a Body"),
])
def test_a_body_that_is_none_is_refused_by_name(call, words):
    with pytest.raises(dermis.Error) as refused:
        call(contact.Pad(np.zeros((4, 4), np.float32), 1e-3))
    assert str(refused.value).startswith(words), refused.value


def changing(change, at_once):
    """Call at_once() again and again while another thread calls change(0), change(1) .."""
    ended = threading.Event()

    def go_on():
        count = itertools.count()
        while not ended.is_set():
            change(next(count))

    thread = threading.Thread(target=go_on)
    thread.start()
    try:
        for _ in range(2000):
            at_once()
    finally:
        ended.set()
        thread.join()


def test_a_press_takes_a_touch_of_one_call_while_another_thread_adds():
    made = dermis.Skin(dermis.fingertip(grid={"width": SIDE, "height": SIDE, "spacing": CELL}), count=64)
    touch = contact.Touch(made, reach=1e-3)
    middles, axes, pad = np.zeros((64, 3)), np.tile(np.eye(3), (64, 1, 1)), np.arange(64)

    def press():
        made.reset()
        made.press(touch, 1e-3)
        one = made["sa1"].reshape(64, -1)
        assert (one == one[0]).all()

    changing(lambda i: touch.add(middles, axes, pad, middles, np.tile([0, 0, -0.1 - i % 7], (64, 1)), radius=2e-3), press)

# SPDX-License-Identifier: MIT
"""Recordings of a sensor array as a load."""
import dermis
import numpy as np
import pytest

CELL, TAXEL = 1e-4, 7.3e-4
SPREADS = ["nearest", "linear", "cubic"]


def spline(spread, u):
    """A B-spline whose nodes are 1 apart, in closed form."""
    u = np.abs(u)
    if spread == "nearest":
        return (u < 0.5).astype(float)
    if spread == "linear":
        return np.maximum(0, 1 - u)
    return np.where(u < 1, 2 / 3 - u**2 + u**3 / 2, np.maximum(0, 2 - u) ** 3 / 6)


def scene(path, spacing=TAXEL, origin=(0, 0), width=80, height=60, load={}, output={}, material={}, **taxels):
    return dermis.fingertip(grid={"width": width, "height": height, "spacing": CELL},
                            load={"kind": "sequence", "path": path, **({"interval": "10 ms"} | load),
                                  "taxels": {"spacing": spacing, "origin": list(origin), "unit": "Pa", "offset": 0} | taxels},
                            time={"step": "5 ms", "duration": 0.1}, output=output, material=material)


def pressure_of(path, **keys):
    """The pressure of the first frame, as the strain that it gives a spring of 1 Pa."""
    first = path.with_name(f"first_{path.name}")
    if path.suffix == ".npy":
        np.save(first, np.load(path)[:1])
    else:
        lines = path.read_text().splitlines()
        first.write_text("\n".join(lines[:2]))
    spring = scene(first, output={"traces": [], "fields": [{"at": 0.1, "what": ["strain"]}]},
                   material={"modulus": 1, "viscosity": 0}, **keys)
    return dermis.run(spring, precision="f64").fields["strain", 0.1]


def saved(folder, frames, name="recording.npy"):
    np.save(folder / name, frames)
    return folder / name


@pytest.fixture
def recording():
    return np.random.default_rng(5).random((6, 8, 10)).astype(np.float32)


@pytest.mark.parametrize("spread", SPREADS)
@pytest.mark.parametrize("origin", [(0, 0), (3.1e-4, 0.7e-4), (7e-4, 1.6e-4)])
def test_the_force_of_the_taxels_is_kept(tmp_path, recording, spread, origin):
    pressure = pressure_of(saved(tmp_path, recording), origin=origin, spread=spread)
    force = recording[0].astype(float).sum() * TAXEL**2
    assert pressure.sum() * CELL**2 == pytest.approx(force, rel=1e-12)


@pytest.mark.parametrize("spread", SPREADS)
def test_an_even_pressure_stays_even(tmp_path, spread):
    path = saved(tmp_path, np.ones((1, 8, 10)))
    pressure = pressure_of(path, spacing=8e-4, height=64, spread=spread)
    np.testing.assert_allclose(pressure, 1, rtol=1e-12)


def test_taxels_of_whole_cells_are_repeated_by_nearest(tmp_path, recording):
    pressure = pressure_of(saved(tmp_path, recording), spacing=7e-4, origin=(5e-4, 2e-4), spread="nearest")
    expected = np.zeros((60, 80))
    expected[2:58, 5:75] = np.kron(recording[0], np.ones((7, 7)))
    np.testing.assert_allclose(pressure, expected, atol=1e-12)


@pytest.mark.parametrize("spread", SPREADS)
def test_a_taxel_is_spread_by_the_means_of_a_b_spline_over_cells(tmp_path, spread):
    one = np.zeros((1, 8, 10))
    one[0, 3, 6] = 2.5
    pressure = pressure_of(saved(tmp_path, one), spread=spread)
    within = (np.arange(200) + 0.5) / 200  # of a cell

    def mean(cells, taxel):
        place = (np.arange(cells)[:, None] + within) * CELL / TAXEL - (taxel + 0.5)
        return spline(spread, place).mean(axis=1)
    tolerance = 0.02 if spread == "nearest" else 1e-4  # of the means by 200 places in a cell
    np.testing.assert_allclose(pressure, 2.5 * np.outer(mean(60, 3), mean(80, 6)), atol=tolerance)


@pytest.mark.parametrize("spread", SPREADS)
def test_a_run_has_the_bits_of_the_same_pressures_on_cells(tmp_path, recording, spread):
    frames = [pressure_of(saved(tmp_path, recording[n:], f"{n}.npy"), spread=spread) for n in range(len(recording))]
    run = dermis.run(scene(saved(tmp_path, recording), spread=spread))
    same = dermis.run(dermis.fingertip(
        grid={"width": 80, "height": 60, "spacing": CELL}, time={"step": "5 ms", "duration": 0.1},
        load={"kind": "sequence", "path": saved(tmp_path, np.array(frames), "cells.npy"), "interval": "10 ms"}))
    for name in same:
        np.testing.assert_array_equal(run[name].mean, same[name].mean)
        np.testing.assert_array_equal(run[name].max, same[name].max)


NAMES = ",".join(f"taxel_{i}" for i in range(80))


QUOTED = '"' + NAMES.replace(",", '","') + '"'


@pytest.mark.parametrize("text", ["{}", NAMES + "\n{}", "{}\n\n", "\ufeff{}", "# of 8 x 10\n" + QUOTED + "\n{}"])
@pytest.mark.parametrize("line", ["\n", "\r\n"])
def test_a_csv_file_has_the_bits_of_an_array(tmp_path, recording, text, line):
    rows = "\n".join(", ".join(f"{float(v):+}" for v in frame.ravel()) for frame in recording)
    (tmp_path / "recording.csv").write_bytes(text.format(rows).replace("\n", line).encode())
    by_csv = dermis.run(scene(tmp_path / "recording.csv", rows=8, columns=10))
    by_npy = dermis.run(scene(saved(tmp_path, recording)))
    for name in by_npy:
        np.testing.assert_array_equal(by_csv[name].mean, by_npy[name].mean)


def test_other_columns_are_left_out_where_they_are_counted(tmp_path, recording):
    rows = "\n".join(f"{i},2024-05-01 12:00:{i},25.1," + ",".join(map(repr, map(float, frame.ravel())))
                     for i, frame in enumerate(recording))
    (tmp_path / "recording.csv").write_text("frame,time,temperature," + NAMES + "\n" + rows)
    of_csv = pressure_of(tmp_path / "recording.csv", rows=8, columns=10, skip=3)
    np.testing.assert_array_equal(of_csv, pressure_of(saved(tmp_path, recording)))
    for skip in (0, 2, 4):
        with pytest.raises(dermis.Error, match=rf"recording.csv\":1: line = .*; allowed: {80 + skip} columns with commas "
                                               rf"between them, .*: 8 rows of 10 taxels, after load.taxels.skip = {skip}"):
            scene(tmp_path / "recording.csv", rows=8, columns=10, skip=skip)


def test_an_array_in_the_order_of_fortran_has_the_same_bits(tmp_path, recording):
    for kind in ("<f4", ">f8"):
        by_c = dermis.run(scene(saved(tmp_path, recording.astype(kind))))
        by_fortran = dermis.run(scene(saved(tmp_path, np.asfortranarray(recording.astype(kind)))))
        for name in by_c:
            np.testing.assert_array_equal(by_fortran[name].mean, by_c[name].mean)


@pytest.mark.parametrize("unit, pascal", [("Pa", 1), ("kPa", 1e3), ("12 Pa", 12), ("-2.5 kPa", -2500), (3, 3),
                                          ("mN", 1e-3 / TAXEL**2), ("-2 mN", -2e-3 / TAXEL**2)])
def test_numbers_have_a_unit_and_begin_at_their_offset(tmp_path, recording, unit, pascal):
    later = recording[1:].astype(float)
    for offset, at_rest in ((0, 0), (0.25, 0.25), ("first", later[0])):
        run = dermis.run(scene(saved(tmp_path, later), unit=unit, offset=offset))
        same = dermis.run(scene(saved(tmp_path, pascal * (later - at_rest), "pascal.npy")))
        for name in same:
            np.testing.assert_allclose(run[name].mean, same[name].mean, rtol=1e-9, atol=1e-12 * abs(same[name].mean).max())


def test_a_depth_of_taxels_is_in_metres(tmp_path, recording):
    pressed = dict(load={"control": "depth"}, output={"traces": ["strain"]})
    depth, same = (dermis.run(scene(saved(tmp_path, recording), unit=unit, **pressed)) for unit in ("0.1 mm", 1e-4))
    np.testing.assert_array_equal(depth["strain"].max, same["strain"].max)
    for unit in ("kPa", "mN"):
        with pytest.raises(dermis.Error, match=f'load.taxels.unit = "{unit}"; allowed: .* as "mm"'):
            scene(saved(tmp_path, recording), unit=unit, **pressed)


def test_a_first_frame_that_is_not_at_rest_asks_for_an_offset(tmp_path, recording):
    recording[0] = 0
    scene(saved(tmp_path, recording), offset=None)
    recording[0, 3, 6] = 512
    with pytest.raises(dermis.Error, match=r'offset = .not given.; allowed: offset = "first" where the first frame is at '
                                           r'rest, or offset = 0 or another number at rest: .* has 512 at taxel \[6, 3\]'):
        scene(saved(tmp_path, recording), offset=None)


def test_a_sampling_rate_is_one_over_the_interval(tmp_path, recording):
    path = saved(tmp_path, recording)
    by_rate = dermis.run(scene(path, load={"interval": None}, sampling_rate="0.1 kHz"))
    np.testing.assert_array_equal(by_rate["fa1"].mean, dermis.run(scene(path))["fa1"].mean)


def test_what_a_recording_cannot_be_is_refused_by_name(tmp_path, recording):
    path = saved(tmp_path, recording)
    for keys, says in [
            (dict(spacing=9e-4), "load.taxels.origin = 0; allowed: a place from which all taxels lie on the grid: 10 along "
                                 "x are 0.009 long, the grid 0.008"),
            (dict(origin=(-1e-4, 0)), "load.taxels.origin = -1e-04; allowed: a place"),
            (dict(spread="round"), "load.taxels.spread = 'round'; allowed: \"cubic\", \"linear\", \"nearest\""),
            (dict(columns=3, rows=2), r"npy\":1: line = \".NUMPY.*; allowed: text in UTF-8: UTF-16 and binary files"),
            (dict(columns=3), "load.taxels.rows = .not given.; allowed: a number of taxels, as rows = 4 and columns = 4")]:
        with pytest.raises(dermis.Error, match=says):
            dermis.run(scene(path, **keys))
    unnamed = "; names take one line, and units none"
    for text, says in [("1,2,3,4\n1,2,3\n", ":2: line = \"1,2,3\"; allowed: 4 columns with commas between them, and decimals"),
                       ("1,2,x,4\n", ":1: column 3 = \"x\"; allowed: a finite number; the line: \"1,2,x,4\""),
                       ("1,2,nan,4\n", ":1: column 3 = nan; allowed: a finite number"),
                       ("nan,nan,nan,nan\n1,2,3,4\n", ":1: column 1 = nan"),
                       ("a,b,c,d\n(kPa),(kPa),(kPa),(kPa)\n1,2,3,4\n", f":2: column 1 = \".kPa.\"; .*{unnamed}"),
                       ("(kPa),(kPa),(kPa),(kPa)\n1,2,3,4\n", f":1: column 1 = \".kPa.\"; .*{unnamed}"),
                       ("a,b,c,d\ne,f,g,h\n1,2,3,4\n", f":2: column 1 = \"e\"; .*{unnamed}"),
                       ("1,2,3,4\na,b,c,d\n", f":2: column 1 = \"a\"; .*{unnamed}"),
                       ("1,5;2,5;3,5;4,5\n", ":1: line = \"1,5;2,5;3,5;4,5\"; allowed: 4 columns with commas between them"),
                       ("1\t2\t3\t4\n", ":1: line = \"1.2.3.4\"; allowed: 4 columns with commas"),
                       ('"0,0","1,5"\n', ":1: line = .*; allowed: no comma within quotes"),
                       ("1,2,3,4\r5,6,7,8\n", ":1: line = .*; allowed: lines that end in LF or CR LF, not in CR alone"),
                       ("1,+-2,3,4\n", ":1: column 2 = \"\\+-2\"; allowed: a finite number"),
                       ("1,1e-400,3,4\n", ":1: column 2 = 1e-400; allowed: 0, or a number from 5e-324 to 1.7e308"),
                       ("a,b,c,d\n", "holds no line of numbers"), ("", "holds no line of numbers"),
                       ("1,,3,4\n", ":1: column 2 = \"\"; allowed: a finite number")]:
        (tmp_path / "bad.csv").write_bytes(text.encode())
        with pytest.raises(dermis.Error, match=f"load.path = .*bad.csv\":? ?{says}"):
            scene(tmp_path / "bad.csv", rows=2, columns=2)
    for name in ("bad.csv", "bad.CSV", "bad.txt"):
        with pytest.raises(dermis.Error, match="load.taxels.columns = .not given.; allowed: a number of taxels, as rows = 4"):
            scene(tmp_path / name)

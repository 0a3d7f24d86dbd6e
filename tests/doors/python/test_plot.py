# SPDX-License-Identifier: MIT
"""Pictures of runs and sweeps, and the page that has them."""
import base64
import io
import json
import pathlib
import re
import xml.etree.ElementTree as ElementTree

import dermis
import numpy as np
import pytest

EXAMPLES = pathlib.Path(__file__).parents[3] / "host/examples"
GRID = {"width": 40, "height": 30, "spacing": 2e-4}
SKIN = dict(preset="fingertip", grid=GRID, load={"intensity": 2e4, "radius": 10}, time={"step": 0.01, "duration": 0.2})
TRACES = dict(SKIN, output={"probes": [[20, 15]], "fields": [{"at": at, "what": ["sa1", "deformation"]}
                                                             for at in (0.05, 0.1)]})
FIBRES = dict(SKIN, sites=[("sa1", 20, 15), ("sa1", 22, 15), ("fa1", 5, 5)], output={"traces": []},
              afferents=[{"type": "sa1", "cells": [[20, 15], [22, 15]], "value": 400},
                         {"type": "fa1", "cells": [[21, 15]]}])


@pytest.fixture(scope="module")
def runs():
    return {"traces": dermis.run(TRACES), "fibres": dermis.run(FIBRES)}


def labels_of(figure):
    """The labels of all axes with data; panels that share an axis have its label once."""
    return {label for axes in figure.axes if axes.has_data()
            for label in (axes.get_xlabel(), axes.get_ylabel()) if label}


def test_a_run_is_drawn_with_a_unit_on_every_axis(runs):
    traces, fibres = dermis.plot(runs["traces"]), dermis.plot(runs["fibres"])
    assert list(traces) == ["traces", "maps", "surface"] and list(fibres) == ["skin", "receptors", "spikes"]
    labels = set().union(*map(labels_of, [*traces.values(), *fibres.values()]))
    without = {label for label in labels if not re.search(r"\((1|s|1/s|1/s²|mm|µm)\)", label)}
    assert without == {"afferent"}
    for figure in [*traces.values(), *fibres.values()]:
        assert all(axes.get_xlabel() or axes.get_shared_x_axes().get_siblings(axes) != [axes]
                   or axes.get_label() == "<colorbar>" for axes in figure.axes if axes.has_data())


def test_lines_are_the_numbers_of_the_run(runs):
    result = runs["traces"]
    panel = dermis.plot(result)["traces"].axes[1]
    lines = {line.get_label(): line.get_xydata().T for line in panel.lines}
    np.testing.assert_array_equal(lines["mean"], [result.time, result["sa1"].mean])
    np.testing.assert_array_equal(lines["probe 0"], [result.time, result["sa1"].probes[0]])


def test_signed_maps_are_blue_to_red_around_zero_and_classes_have_one_colour():
    result = dermis.run(dict(SKIN, sites=[("fa1", 20, 15), ("fa1", 5, 5), ("sa1", 20, 15)], output={
        "fields": [{"at": at, "what": ["sa1", "fa1"]} for at in (0.05, 0.1)]}))
    figures = dermis.plot(result)
    images = [axes.images[0] for axes in figures["maps"].axes if axes.images]
    points = [axes.collections[0] for axes in figures["receptors"].axes if axes.get_title().startswith("2 sites, FA1")]
    assert [image.get_cmap().name for image in images] == ["viridis", "viridis", "RdBu_r", "RdBu_r"]
    assert len(points) == 1 and points[0].get_cmap().name == "RdBu_r"
    for signed in [*images[2:], *points]:
        low, high = signed.get_clim()
        assert low == -high and high >= np.abs(signed.get_array()).max()
    lines = [line for axes in figures["receptors"].axes for line in axes.lines if line.get_label() == "median"]
    assert [line.get_color() for line in lines] == ["#0072B2", "#D55E00"]
    page = (EXAMPLES / "page/page.js").read_text()
    assert all(f"{name}: '{colour.lower()}'" in page for name, colour in (("SA1", "#0072B2"), ("FA1", "#D55E00")))


def test_no_legend_lies_on_its_panel(runs):
    for figure in [*dermis.plot(runs["traces"]).values(), *dermis.plot(runs["fibres"]).values()]:
        figure.savefig(io.BytesIO())  # which lays the figure out
        for axes in figure.axes:
            if legend := axes.get_legend():
                assert legend.get_window_extent().y0 >= axes.bbox.y1 - 1


def test_the_page_begins_with_the_load_the_greatest_responses_and_the_bound(runs, tmp_path):
    dermis.plot(runs["traces"], tmp_path)
    page = (tmp_path / "report.html").read_text()
    head = re.findall(r"<tr><th>(.*?)</th><td>(.*?)</td></tr>", page)
    assert [name for name, _ in head[:3]] == ["pressed", "greatest responses", "error at most"]
    fa1 = runs["traces"]["fa1"]
    assert head[0][1] == "circular load of 20,000 Pa, envelope step"
    assert f"FA1 {fa1.max.max():.4g} 1/s at {runs['traces'].time[fa1.max.argmax()]:.4g} s" in head[1][1]
    slim = re.findall(r'<source media="\(max-width: 700px\)" srcset="data:image/svg\+xml;base64,([^"]*)"', page)
    wide = re.findall(r'<img alt="[^"]*" src="data:image/svg\+xml;base64,([^"]*)"', page)
    points = [float(ElementTree.fromstring(base64.b64decode(svg)).get("width")[:-2]) for svg in slim + wide]
    assert len(slim) == len(wide) == 3 and max(points[:3]) < 303 < min(points[3:])  # 4.2 inches


def test_the_skin_shows_the_footprint_of_a_punch_and_where_afferents_are():
    result = dermis.run(dict(FIBRES, load={"kind": "punch", "control": "depth", "radius": 4, "center": [10, 20],
                                           "intensity": 1e-4}))
    panel = dermis.plot(result)["skin"].axes[0]
    (punch,) = panel.patches
    assert punch.center == pytest.approx((2.1, 4.1)) and (punch.width, punch.height) == pytest.approx((1.6, 1.6))
    sa1, fa1 = (line.get_xydata() for line in panel.lines)
    np.testing.assert_allclose([*sa1, *fa1], [[4.1, 3.1], [4.5, 3.1], [4.3, 3.1]])


def test_maps_have_millimetres_and_one_range_of_colours(runs):
    figure = dermis.plot(runs["traces"])["maps"]
    images = [axes.images[0] for axes in figure.axes if axes.images]
    assert len(images) == 4 and all(image.get_extent() == pytest.approx([0, 8, 0, 6]) for image in images)
    heights = [runs["traces"].fields["deformation", at] * 1e6 for at in (0.05, 0.1)]
    assert {image.get_clim() for image in images[2:]} == {(min(map(np.min, heights)), max(map(np.max, heights)))}


def test_an_impulse_is_an_arrow_with_its_weight(runs):
    impulse = next(i for i in runs["traces"].impulses if i.quantity == "fa2")
    texts = [text.get_text() for text in dermis.plot(runs["traces"])["traces"].axes[4].texts]
    assert f" {impulse.mean:.3g} 1/s" in texts


def test_each_spike_is_a_mark_in_the_row_of_its_fibre(runs):
    raster = dermis.plot(runs["fibres"])["spikes"].axes[0]
    marks = np.concatenate([line.get_xydata() for line in raster.lines])
    spikes = runs["fibres"].spikes
    assert len(spikes) > 1 and sorted(map(tuple, marks)) == sorted(zip(spikes["time"], spikes["afferent"]))


def test_the_page_needs_no_other_file_and_the_same_run_makes_the_same_files(runs, tmp_path):
    for folder in ("a", "b"):
        dermis.plot(runs["traces"], tmp_path / folder)
    names = {path.name for path in (tmp_path / "a").iterdir()}
    assert names == {"report.html", *(f"{name}.{kind}" for name in ("traces", "maps", "surface")
                                      for kind in ("png", "svg"))}
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    page = (tmp_path / "a/report.html").read_text()
    sources = re.findall(r'(?:src|href)="([^"]*)"', page)
    assert len(sources) == 3 and all(source.startswith("data:image/svg+xml;base64,") for source in sources)
    for source in sources:
        svg = base64.b64decode(source.partition(",")[2])
        assert ElementTree.fromstring(svg).tag.endswith("svg") and svg in [
            (tmp_path / f"a/{name}.svg").read_bytes() for name in ("traces", "maps", "surface")]


def test_a_sweep_is_drawn_over_the_key_with_the_most_values():
    rows = dermis.sweep(dict(TRACES, output={}), {"load.intensity": [1e4, 2e4, 4e4], "surface.kind": ["wave", "flat"]})
    figures = dermis.plot(rows)
    assert list(figures) == ["sweep"]
    axes = figures["sweep"].axes
    assert axes[-1].get_xlabel() == "load.intensity (Pa)" and len(axes) == 10
    lines = {line.get_label(): line.get_xydata() for line in axes[0].lines}
    expected = [(row["load.intensity"], row["result"]["strain"].mean.max()) for row in rows
                if row["surface.kind"] == "flat"]
    np.testing.assert_allclose(lines["surface.kind = flat"], expected)
    texts = dermis.plot(dermis.sweep(dict(TRACES, output={}), {"surface.kind": ["wave", "flat"]}))["sweep"]
    assert [tick.get_text() for tick in texts.axes[-1].get_xticklabels()] == ["wave", "flat"]


def test_a_sweep_of_what_is_traced_shows_what_some_runs_have_and_a_grid_of_one_cell_no_surface():
    one = dict(TRACES, grid=dict(GRID, width=1, height=1), load={}, output=dict(TRACES["output"], probes=[]))
    assert list(dermis.plot(dermis.run(one))) == ["traces", "maps"]
    rows = dermis.sweep(dict(one, output={}), {"output.traces": [[], ["sa1"], ["fa1", "sa1"]], "output.extremes": [False, True]})
    axes = dermis.plot(rows)["sweep"].axes
    drawn = [np.isfinite(line.get_ydata()).sum() for panel in axes for line in panel.lines]
    assert len(axes) == 4 and drawn == [2, 2, 0, 2, 1, 1, 0, 1]


def test_rows_have_the_values_and_what_each_trace_comes_to():
    rows = dermis.sweep(dict(TRACES, output={"probes": [[20, 15]]}), {"load.intensity": [1e4, 2e4]})
    for row in rows:
        fa1 = row["result"]["fa1"]
        for name, values in {"fa1_mean": fa1.mean, "fa1_min": fa1.min, "fa1_probe0": fa1.probes[0]}.items():
            peak = np.abs(values).argmax()
            assert row[f"{name}_final"] == values[-1] and row[f"{name}_peak"] == values[peak]
            assert row[f"{name}_peak_time"] == row["result"].time[peak]
    assert [row["load.intensity"] for row in rows] == [1e4, 2e4] and rows[0]["set"] == "load.intensity=10000.0"


def test_what_cannot_be_drawn_is_refused_by_name(tmp_path):
    with pytest.raises(dermis.Error, match=r"what = \[\]; allowed: a Result, the rows of sweep\(\), or a folder"):
        dermis.plot([])
    with pytest.raises(dermis.Error, match=r"what = float64 array of shape \(3,\); allowed: a Result, the rows of"):
        dermis.plot(np.zeros(3))
    with pytest.raises(dermis.Error, match=r"what = \[\{'a': 1\}\]; allowed: a Result, the rows of"):
        dermis.plot([{"a": 1}])
    (tmp_path / "summary.json").write_text("{}")
    with pytest.raises(dermis.Error, match=r"what = .*: has neither summary.json nor runs.csv of dermis; allowed: a folder"):
        dermis.plot(tmp_path)


OURS = '{\n  "program": "dermis", '  # begins each summary.json


@pytest.mark.parametrize("name, text, says", [
    ("summary.json", OURS + '"met', "Unterminated string"), ("traces.csv", "", "its first column is not time"),
    ("traces.csv", "time,sa1_mean\n0,x\n", "could not convert string to float: 'x'"),
    ("sa1_t0.05.npy", "\x93NUMPY", "EOF"), ("responses.npy", "no numbers", "pickled")])
def test_a_damaged_file_of_a_folder_is_named(tmp_path, name, text, says):
    files = ["traces.csv", "receptors.csv", "sa1_t0.05.npy"][:2 + name.startswith("sa1")]
    (tmp_path / "summary.json").write_text(OURS + '"files": ' + json.dumps([{"file": file} for file in files]) + "}")
    (tmp_path / "traces.csv").write_text("time,sa1_mean\n0,0\n")
    (tmp_path / "receptors.csv").write_text("type,x,y\nsa1,1,2\n")
    (tmp_path / name).write_bytes(text.encode("latin-1"))
    with pytest.raises(dermis.Error, match=rf"what = .*/{name}: cannot be read \(.*{says}"):
        dermis.plot(tmp_path)


def test_spikes_of_sa1_lie_where_the_dots_of_a_word_in_braille_are():
    letters = {"t": (2, 3, 4, 5), "o": (1, 3, 5), "u": (1, 3, 6), "c": (1, 4), "h": (1, 2, 5)}
    dots = np.array([(11 + 6 * i + 2.5 * ((dot - 1) // 3), 7 - 2.5 * ((dot - 1) % 3))
                     for i, letter in enumerate(letters.values()) for dot in letter])  # mm
    result = dermis.run(dermis.Scene.from_file(EXAMPLES / "braille.toml"))
    panel = dermis.plot(result)["events"].axes[0]
    assert panel.get_title().startswith("SA1, ")
    away = np.linalg.norm(panel.lines[0].get_xydata()[:, None] - dots, axis=2)
    assert (away.min(axis=1) < 1).mean() > 0.8 and ((away < 1).sum(axis=0) > 50).all()


DOTS = np.array([[10.1, 2.1], [13.1, 6.1]])  # x and y of their centres, mm; no dot lies on the skin at t = 0


def moving(load):
    """A run under a load for 0.8 s of even skin with cells of 0.2 mm, 8 mm wide and high, with afferents all over it: SA1
    in cells of even x and y, FA1 in odd ones."""
    random = np.random.default_rng(1)
    afferents = [{"type": kind, "cells": (2 * random.integers(0, 20, (60, 2)) + odd).tolist()}
                 for odd, kind in enumerate(("sa1", "fa1"))]
    return dermis.run(dict(preset="fingertip", grid={"width": 40, "height": 40, "spacing": 2e-4},
                           surface={"kind": "flat"}, receptors={"depth": "fingertip"}, afferents=afferents,
                           load=load, time={"step": 2e-3, "duration": 0.8}, output={"traces": []}))


def dots_under(axis):
    """A load with two dots of 1.5 mm, 16 mm by 8 mm, that moves along an axis at 40 mm/s and passes twice."""
    y, x = (np.mgrid[0:40, 0:80] + 0.5) * 0.2
    dots = sum(np.hypot(x - at[0], y - at[1]) <= 0.75 for at in DOTS).astype(float)
    return {"kind": "linear", "radius": 65536, "intensity": 3e4, "texture": {
        "path": dots if axis == 0 else dots.T, "velocity": [0.04, 0] if axis == 0 else [0, 0.04]}}


def places_in(figure):
    return [np.concatenate([line.get_xydata() for line in axes.lines]) for axes in figure.axes]


@pytest.mark.parametrize("axis", [0, 1])
def test_spikes_lie_where_the_dots_of_a_moving_pattern_do(axis):
    result = moving(dots_under(axis))
    places = places_in(dermis.plot(result)["events"])
    assert len(places) == 2 and sum(map(len, places)) == len(result.spikes)
    for odd, of_class in enumerate(places):
        assert set((of_class[:, 1 - axis] / 0.2 - 0.5).round() % 2) == {odd}
        of_class = of_class if axis == 0 else of_class[:, ::-1]
        near = np.hypot(*(of_class[:, None] - DOTS).T)
        assert (near.min(0) < 0.75 + 0.5).mean() > 0.9
        for dot in range(2):
            assert (near.argmin(0) == dot).sum() > 20
    for dot, at in enumerate(DOTS):  # FA1 fires at the edge that comes first, SA1 all over a dot
        sa1 = places[0] if axis == 0 else places[0][:, ::-1]
        assert np.hypot(*(sa1[np.hypot(*(sa1 - at).T) < 1.25].mean(0) - at)) < 0.5


def test_spikes_lie_on_the_crests_of_a_grating_that_moves_in_any_direction():
    for direction in (0.0, np.pi / 2, 2.2):
        grating = {"wavelength": 2e-3, "velocity": 0.04, "direction": direction}
        result = moving({"kind": "linear", "radius": 65536, "intensity": 3e3, "grating": grating})
        x, y = places_in(dermis.plot(result)["events"])[0].T
        phases = np.exp(2j * np.pi * (x * np.cos(direction) + y * np.sin(direction)) / 2)
        assert len(x) > 1000 and np.abs(phases.mean()) > 0.7


def test_a_pattern_is_drawn_only_if_one_moves(runs):
    still, even = dots_under(0), {"kind": "linear", "radius": 65536, "intensity": 3e4}
    still["texture"] = {**still["texture"], "velocity": [0, 0]}
    wave = {**even, "grating": {"wavelength": 2e-3, "velocity": 0.04}}
    drawn = [list(dermis.plot(moving(load))) for load in (still, [wave, even], [wave, wave])]
    assert drawn == [["skin", "spikes"], ["skin", "spikes", "events"], ["skin", "spikes"]]
    assert "events" not in dermis.plot(runs["fibres"])


WAYS = [("exact", "moments", "f64", "cpu", "0.02", "1e-16", "1e-15"), ("exact", "march", "f32", "cpu", "0.01", "1e-6", "2e-4"),
        ("exact", "march", "f32", "a device", "0.05", "1e-6", "2e-4"),
        *((name, "march", "f64", "cpu", "0.03", "1e-3", "") for name in ("euler", "rk2", "rk4", "backward-euler", "sdirk2"))]


def test_the_errors_of_a_scene_say_which_way_keeps_its_tolerance_and_families_share_a_colour():
    names = ("method", "model", "precision", "device", "seconds", "error", "bound")
    rows = [dict(zip(names, way), seconds_low=way[4], seconds_high=way[4]) for way in WAYS]
    figure = dermis._plot.errors(rows, "press.toml", 1e-4)
    axes, = figure.axes
    assert axes.get_title() == "press.toml: the tolerance of 0.0001 is kept in 20 ms, by moments in f64"
    assert any(list(line.get_ydata()) == [1e-4, 1e-4] and line.get_linestyle() == ":" for line in axes.lines)
    colours = {text.get_text(): text.get_color() for text in axes.texts}
    assert colours["euler"] == colours["rk4"] != colours["sdirk2"] != colours["moments f64"] == colours["march f32, Vulkan"]
    figure.canvas.draw()
    assert all("times" not in text.get_text() for text in [*axes.get_xticklabels(), *axes.get_yticklabels()])
    written = [text.get_window_extent() for text in axes.texts]
    assert not any(one.overlaps(other) for i, one in enumerate(written) for other in written[:i])
    strict = dermis._plot.errors(rows, "press.toml", 1e-15 / 2)
    assert strict.axes[0].get_title() == "press.toml: the tolerance of 5e-16 is kept by no way"

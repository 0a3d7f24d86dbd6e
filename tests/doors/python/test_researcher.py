# SPDX-License-Identifier: MIT
"""A researcher's day: five tasks with measured data, each in at most ten lines, and the picture that it draws."""
import inspect

import dermis
import numpy as np
import pytest
from PIL import Image


def a_measured_print_with_200_receptors(folder):
    scene = dermis.fingertip(
        grid={"width": 100, "height": 100, "spacing": "0.1 mm"},
        surface={"kind": "file", "path": folder / "print.png", "high": "white", "spacing": 25.4e-3 / 500,
                 "relief": "60 um"},
        load={"intensity": "20 kPa", "center": ["5 mm", "5 mm"], "radius": "3 mm"}, time={"duration": 0.2},
        sites={"density": {"sa1": 70, "fa1": 105, "fa2": 25}}, output={"traces": []})
    return dermis.plot(dermis.run(scene), folder / "out")


def a_sliding_grating(folder):
    result = dermis.run(dermis.fingertip(
        load={"intensity": "10 kPa", "radius": "3 mm", "grating": {"wavelength": "1 mm", "velocity": "40 mm/s",
                                                                   "amplitudes": [0.5]}},
        time={"step": "1 ms", "duration": 1}, output={"probes": [["5 mm", "5 mm"]], "extremes": False}))
    return dermis.plot(result, folder / "out"), result


def a_sweep_of_25_runs(folder):
    values = {"material.modulus": np.geomspace(0.3, 30, 5), "load.rise": np.linspace(0.1, 1, 5)}
    rows = dermis.sweep("scene.toml", values)
    return dermis.plot(rows, folder / "out"), rows


def a_relaxation_curve(folder):
    scene = dermis.Scene(material={"elements": dermis.fit(folder / "curve.csv").elements}, time={"duration": 1})
    return dermis.plot(dermis.run(scene), folder / "out"), scene


def a_figure_for_a_paper(folder):
    figures = dermis.plot(dermis.run("scene.toml"))
    figures["traces"].set_size_inches(3.5, 5)
    figures["traces"].savefig(folder / "figure.pdf")


TASKS = [a_measured_print_with_200_receptors, a_sliding_grating, a_sweep_of_25_runs, a_relaxation_curve,
         a_figure_for_a_paper]


@pytest.fixture(autouse=True)
def data(tmp_path, monkeypatch):
    """A print of 500 dpi, a relaxation curve with noise and a scene, as a researcher has them."""
    y, x = np.mgrid[:200, :200] * 25.4e-3 / 500
    heights = 0.5 + 0.5 * np.sin(2 * np.pi / 0.46e-3 * np.hypot(x - 5e-3, y - 8e-3))
    Image.fromarray((65535 * heights).astype(np.uint16)).save(tmp_path / "print.png")
    t = np.geomspace(1e-3, 10, 80)
    noise = np.random.default_rng(1).normal(1, 0.01, t.size)
    modulus = (2e4 + 3e4 * np.exp(-t / 0.02) + 3e4 * np.exp(-t / 1.1)) * noise
    np.savetxt(tmp_path / "curve.csv", np.column_stack([t, modulus]), delimiter=",", header="time,modulus", comments="")
    (tmp_path / "scene.toml").write_text('[surface]\nkind = "spiral"\n[load]\nenvelope = "ramp"\nrise = 0.5\n')
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("task", TASKS)
def test_a_task_is_at_most_ten_lines(task):
    assert len(inspect.getsource(task).splitlines()) <= 10


def test_a_measured_print_is_felt_by_its_receptors(tmp_path):
    figures = a_measured_print_with_200_receptors(tmp_path)
    assert list(figures) == ["skin", "receptors"] and (tmp_path / "out/report.html").exists()
    titles = [axes.get_title() for axes in figures["receptors"].axes if axes.get_title()]
    assert [title.split(",")[0] for title in titles] == ["70 sites", "105 sites", "25 sites"]


def test_a_grating_of_1_mm_at_40_mm_per_s_vibrates_at_40_hz(tmp_path):
    figures, result = a_sliding_grating(tmp_path)
    fa1 = result["fa1"].probes[0][500:]
    assert np.fft.rfftfreq(fa1.size, 1e-3)[np.abs(np.fft.rfft(fa1 - fa1.mean())).argmax()] == pytest.approx(40, abs=1)
    assert list(figures) == ["skin", "traces"]


def test_a_sweep_has_its_table_and_its_chart(tmp_path):
    figures, rows = a_sweep_of_25_runs(tmp_path)
    assert len(rows) == 25 and figures["sweep"].axes[-1].get_xlabel() in ("material.modulus (Pa)", "load.rise (s)")
    softest = [row["fa1_max_peak"] for row in rows if row["material.modulus"] == rows[0]["material.modulus"]]
    assert softest == sorted(softest, reverse=True)  # the slower the ramp, the less FA1


def test_a_curve_becomes_the_material_of_a_scene(tmp_path):
    figures, scene = a_relaxation_curve(tmp_path)
    strain = dermis.run(scene)["strain"]
    at_once = strain.max[1]
    assert at_once == pytest.approx(1 / 8e4, rel=0.2) and strain.max[-1] > 1.5 * at_once and "traces" in figures


def test_a_figure_goes_into_a_paper(tmp_path):
    a_figure_for_a_paper(tmp_path)
    assert (tmp_path / "figure.pdf").read_bytes().startswith(b"%PDF")

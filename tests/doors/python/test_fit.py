# SPDX-License-Identifier: MIT
"""Chains of elements from measured curves."""
import dermis
import numpy as np
import pytest


def test_a_measured_creep_gives_its_elements_back():
    times = np.geomspace(1e-3, 10, 60)
    compliance = (1 - np.exp(-times / 0.02)) / 3e4 + (1 - np.exp(-times / 1.0)) / 5e4
    fit = dermis.fit_creep(times, compliance, 2)
    np.testing.assert_allclose([(e.modulus, e.viscosity) for e in fit.elements], [(3e4, 600), (5e4, 5e4)], rtol=1e-6)
    np.testing.assert_allclose(fit.model, compliance, rtol=1e-6)
    assert fit.residual < 1e-6 and not fit.undetermined and len(fit.errors) == 2


def test_a_relaxation_becomes_a_chain_and_comes_back():
    chain = dermis.chain_of(dermis.Relaxation(moduli=[2e4, 1e4], times=[0.01, 1.0], equilibrium=1e4))
    back = dermis.relaxation_of(chain)
    np.testing.assert_allclose([*back.moduli, *back.times, back.equilibrium], [2e4, 1e4, 0.01, 1.0, 1e4])
    times = np.geomspace(1e-3, 10, 50)
    moduli = 1e4 + 2e4 * np.exp(-times / 0.01) + 1e4 * np.exp(-times / 1.0)
    fit = dermis.fit_relaxation(times, moduli, 3, residual="absolute")
    np.testing.assert_allclose([e.modulus for e in fit.elements], [e.modulus for e in chain], rtol=1e-4)


def test_a_chain_is_a_material():
    chain = dermis.chain_of(dermis.Relaxation(moduli=[1.0], times=[0.5], equilibrium=2.0))
    load = {"path": np.ones((4, 4))}
    common = dict(grid={"width": 4, "height": 4}, load=load, time={"step": 0.1, "duration": 2})
    by_chain = dermis.run(dermis.Scene(**common, material=dermis.Material(elements=chain)))
    given = dermis.Relaxation(moduli=[1.0], times=[0.5], equilibrium=2.0)
    by_relaxation = dermis.run(dermis.Scene(**common, material=dermis.Material(relaxation=given)))
    np.testing.assert_array_equal(by_chain["strain"].mean, by_relaxation["strain"].mean)


def test_what_cannot_be_fitted_is_refused_by_name():
    with pytest.raises(dermis.Error) as caught:
        dermis.fit_creep([1.0, 2.0], [1.0, 2.0], 1)
    assert caught.value.code == "bad_input" and caught.value.parameter
    with pytest.raises(dermis.Error, match='residual = "square"; allowed: "absolute", "relative"'):
        dermis.fit_creep([1.0, 2.0, 3.0], [1.0, 2.0, 3.0], 1, "square")


FINGERPAD = dermis.Relaxation(moduli=[2.5e5, 2.5e5, 2.5e5], times=[4e-3, 7e-2, 1.4], equilibrium=2.5e5)


def relaxing(relaxation, times):
    return relaxation.equilibrium + sum(m * np.exp(-times / t) for m, t in zip(relaxation.moduli, relaxation.times))


def stress_of(relaxation, times, strains):
    """The hereditary integral of a strain along lines, from each piece by itself; the strain is 0 before."""
    rates = np.diff(strains) / np.diff(times)
    stress = relaxation.equilibrium * strains
    for modulus, time in zip(relaxation.moduli, relaxation.times):
        for i, t in enumerate(times):
            stress[i] += modulus * strains[0] * np.exp(-(t - times[0]) / time)
            begin, end = t - times[:i], t - times[1:i + 1]
            stress[i] += modulus * time * np.sum(rates[:i] * (np.exp(-end / time) - np.exp(-begin / time)))
    return stress


def numbers_of(fit):
    return [(e.modulus, e.viscosity) for e in fit.elements]


def ramp(rise, times):
    return 0.1 * np.minimum(1, times / rise)


TIMES = np.concatenate([np.linspace(0, 0.1, 101), np.linspace(0.12, 6, 150)])
WALK = np.cumsum(np.random.default_rng(2).normal(0, 0.01, TIMES.size))


@pytest.mark.parametrize("kind, truth", [("relaxation", FINGERPAD), ("creep", FINGERPAD),
                                         ("relaxation", dermis.Relaxation(moduli=[3e4], times=[0.2], equilibrium=1e4))])
@pytest.mark.parametrize("noise", [0, 0.01])
def test_a_fit_without_a_number_takes_as_many_elements_as_the_truth_has(kind, truth, noise):
    chain = dermis.chain_of(truth)
    times = np.geomspace(1e-4, 30, 200)
    curve = relaxing(truth, times)
    if kind == "creep":
        curve = sum((1 - np.exp(-times * e.modulus / (e.viscosity or 1e-99))) / e.modulus for e in chain)
    curve = curve * (1 + noise * np.random.default_rng(4).standard_normal(times.size))
    fit = (dermis.fit_creep if kind == "creep" else dermis.fit_relaxation)(times, curve)
    assert len(fit.elements) == len(chain) and fit.undetermined == []
    assert fit.choice.startswith(f"{len(chain)} elements, because {len(chain) - 1} leave")
    np.testing.assert_allclose(numbers_of(fit), [(e.modulus, e.viscosity) for e in chain], rtol=0.3 if noise else 1e-6)
    assert dermis.fit_relaxation(times, relaxing(truth, times), 4).choice == ""


@pytest.mark.parametrize("strains", [ramp(0.05, TIMES), WALK, np.ones_like(TIMES), np.sin(5 * TIMES)])
def test_the_stress_under_any_strain_gives_the_elements_back(strains):
    fit = dermis.fit_histories([(TIMES, strains, stress_of(FINGERPAD, TIMES, strains))])
    expected = [(e.modulus, e.viscosity) for e in dermis.chain_of(FINGERPAD)]
    np.testing.assert_allclose(numbers_of(fit), expected, rtol=1e-4)
    np.testing.assert_allclose(fit.model, stress_of(FINGERPAD, TIMES, strains), rtol=1e-6, atol=1e-2)


def test_what_relaxes_in_4_ms_is_read_behind_a_ramp_of_50_ms_and_is_lost_where_the_ramp_counts_as_a_step():
    noise = 1 + 1e-3 * np.random.default_rng(1).standard_normal(TIMES.size)
    stress = stress_of(FINGERPAD, TIMES, ramp(0.05, TIMES)) * noise
    first = dermis.relaxation_of(dermis.fit_histories([(TIMES, ramp(0.05, TIMES), stress)], 4).elements)
    assert first.times[0] == pytest.approx(4e-3, rel=0.1) and first.moduli[0] == pytest.approx(2.5e5, rel=0.1)
    held = TIMES > 0.05
    step = dermis.relaxation_of(dermis.fit_relaxation(TIMES[held] - 0.05, stress[held] / 0.1).elements)
    assert step.moduli[0] < 0.1 * 2.5e5


def test_histories_are_fitted_together_each_from_rest():
    slow = (TIMES, ramp(1.0, TIMES), stress_of(FINGERPAD, TIMES, ramp(1.0, TIMES)))
    quick = (TIMES[:100] + 7, WALK[:100], stress_of(FINGERPAD, TIMES[:100], WALK[:100]))
    both = dermis.fit_histories([slow, quick])
    expected = [(e.modulus, e.viscosity) for e in dermis.chain_of(FINGERPAD)]
    np.testing.assert_allclose(numbers_of(both), expected, rtol=1e-3)
    assert both.model.size == TIMES.size + 100
    swapped = dermis.fit_histories([quick, slow])
    np.testing.assert_allclose(swapped.model[:100], both.model[-100:], rtol=1e-4, atol=1)


def test_a_step_of_the_strain_may_stand_between_two_points_at_one_time():
    times = np.concatenate([[0, 1, 1], 1 + np.geomspace(1e-3, 5, 80)])
    strains = np.where(np.arange(times.size) < 2, 0, 0.1)
    stress = np.where(np.arange(times.size) < 2, 0, 0.1 * relaxing(FINGERPAD, times - 1))
    fit = dermis.fit_histories([(times, strains, stress)])
    expected = [(e.modulus, e.viscosity) for e in dermis.chain_of(FINGERPAD)]
    np.testing.assert_allclose(numbers_of(fit), expected, rtol=1e-5)


def test_histories_that_cannot_be_are_refused_by_name():
    good = [0, 1, 2, 3], [0, 1, 1, 1], [0, 5, 4, 3]
    for histories, says in [
            ([], "times = 0 numbers; allowed: at least 3"),
            ([(good[0], good[1][:3], good[2])], r"histories\[0\].strains = 3 numbers; allowed: 4, one for each time"),
            ([good, ([0, 2, 1], [0, 1, 1], [0, 1, 1])], r"histories\[1\].times\[2\] = 1; allowed: no time before"),
            ([([0, 1, 2], [0, 1, 1], [0, 0, 0])], "histories = no stress but 0; allowed: at least one"),
            ([([1, 1, 1], [0, 1, 1], [0, 1, 1])], "histories = no time after the first one"),
            ([([0, 1, np.nan], [0, 1, 1], [0, 1, 1])], r"histories\[0\].times\[2\] = nan"),
            ([(np.arange(20001), np.ones(20001), np.ones(20001))], "histories = 20001; allowed: at most 20000 points"),
            (5, "histories")]:
        with pytest.raises(dermis.Error, match=says):
            dermis.fit_histories(histories)
    with pytest.raises(dermis.Error, match="n = 0; allowed: 1 to 8 elements, or None"):
        dermis.fit_histories([good], 0)


def test_a_scene_takes_its_material_from_a_measured_curve(tmp_path):
    times = np.geomspace(1e-3, 10, 60)
    lines = "\n".join(f"{t!r},{m!r}" for t, m in zip(times.tolist(), relaxing(FINGERPAD, times).tolist()))
    (tmp_path / "curve.csv").write_text(f"# made by hand\ntime,modulus\n{lines}\n")
    tables = {"time": {"step": 0.01, "duration": 0.5}, "grid": {"width": 20, "height": 20}}
    scene = dermis.Scene(tables, material={"relaxation_file": tmp_path / "curve.csv"})
    fitted = dermis.fit_relaxation(times, relaxing(FINGERPAD, times))
    same = dermis.Scene(tables, material={"elements": fitted.elements})
    np.testing.assert_array_equal(dermis.run(scene)["sa1"].max, dermis.run(same)["sa1"].max)
    for keys in ({"spring": 1}, {"modulus": 1}, {"relaxation": FINGERPAD}):
        with pytest.raises(dermis.Error, match="not beside material.*relaxation_file"):
            dermis.Scene(tables, material={"relaxation_file": tmp_path / "curve.csv", **keys})
    (tmp_path / "rises.csv").write_text("time,modulus\n" + "\n".join(f"{t},{10.0 ** t}" for t in range(9)))
    with pytest.raises(dermis.Error, match="relaxation_file = .*rises.csv.; allowed: a curve that a chain of elements"):
        dermis.Scene(tables, material={"relaxation_file": tmp_path / "rises.csv"})
    with pytest.raises(dermis.Error, match="material.relaxation_file = .*none.csv.: .*No such file"):
        dermis.Scene(tables, material={"relaxation_file": tmp_path / "none.csv"})

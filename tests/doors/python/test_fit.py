# SPDX-License-Identifier: MIT
"""Chains of elements from measured curves."""
import sys

import dermis
import numpy as np
import pytest

T = np.geomspace(1e-3, 100, 60)
FINGERPAD = dermis.Relaxation(moduli=[2.5e5, 2.5e5, 2.5e5], times=[4e-3, 7e-2, 1.4], equilibrium=2.5e5)


def pairs(elements):
    return np.array([(e.modulus, e.viscosity) for e in elements])


def creep_of(chain, times):
    """The closed form of a chain's creep."""
    return sum(times / v if m == 0 else np.full_like(times, 1 / m) if v == 0 else -np.expm1(-times * m / v) / m
               for m, v in pairs(chain))


def relaxation_of(r, times):
    return r.equilibrium + sum(m * np.exp(-times / t) for m, t in zip(r.moduli, r.times))


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


def drawn(rng, n, kind):
    """A random chain of n elements whose times are each 1.6 to 20 times the one before, and its curve at T."""
    spring, dashpot = (True, False) if kind == "relaxation" else rng.random(2) < 0.4
    free = max(n - spring - dashpot, 0)
    times = 10 ** (rng.uniform(-2.5, -1.5) + np.cumsum(rng.uniform(0.2, 1.3, free)))
    moduli = 10 ** rng.uniform(4, 6, free + 2)
    if kind == "relaxation":
        r = dermis.Relaxation(moduli=moduli[:free], times=times, equilibrium=moduli[-1])
        return dermis.chain_of(r), relaxation_of(r, T)
    chain = [dermis.KelvinVoigt(modulus=moduli[-1])] * bool(spring)
    chain += [dermis.KelvinVoigt(modulus=m, viscosity=m * t) for m, t in zip(moduli, times)]
    chain += [dermis.KelvinVoigt(viscosity=moduli[-2] * 30)] * bool(dashpot)
    return chain, creep_of(chain, T)


def fit_of(kind, times, values, n=None):
    return (dermis.fit_creep if kind == "creep" else dermis.fit_relaxation)(times, values, n)


def test_of_60_exact_curves_all_chains_come_back_and_of_60_noisy_ones_at_most_one_is_missed():
    missed = 0
    for seed in range(120):
        rng, kind = np.random.default_rng(seed), ("creep", "relaxation")[seed % 2]
        chain, curve = drawn(rng, 1 + seed // 2 % 4, kind)
        noise = 0 if seed < 60 else 10 ** rng.uniform(-4, -1.5)
        measured = curve * (1 + noise * rng.standard_normal(T.size))
        found = fit_of(kind, T, measured, len(chain))
        if noise:
            missed += found.residual > 1.02 * np.sqrt(np.mean((curve / measured - 1)**2))
            continue
        np.testing.assert_allclose(pairs(found.elements), pairs(chain), rtol=1e-4, err_msg=str(seed))
        assert found.residual < 1e-8 and found.undetermined == []
    assert missed <= 1


@pytest.mark.parametrize("kind, points, noise", [("creep", 5, 1e-2), ("creep", 8, 1e-3), ("creep", 44, 1e-2),
                                                 ("relaxation", 60, 1e-2), ("history", 120, 3e-3)])
def test_in_92_to_98_of_100_fits_a_number_is_within_its_interval(kind, points, noise):
    inside = []
    for seed in range(250):
        rng = np.random.default_rng(seed)
        a, b, time = *10 ** rng.uniform(5, 6, 2), 10 ** rng.uniform(-1.8, -1.3)
        times = np.geomspace(3e-3, 3, points)
        if kind == "creep":
            chain = [dermis.KelvinVoigt(modulus=a, viscosity=a * time),
                     dermis.KelvinVoigt(modulus=b, viscosity=b * time * 10 ** rng.uniform(1, 1.5))]
            found = dermis.fit_creep(times, creep_of(chain, times) * (1 + noise * rng.standard_normal(points)), 2)
        else:
            r = dermis.Relaxation(moduli=[a], times=[10 * time], equilibrium=b)
            chain, values = dermis.chain_of(r), relaxation_of(r, times)
            if kind == "history":
                times = np.linspace(0, 3, points)
                strains = ramp(0.1, times)
                values = stress_of(r, times, strains)
                values = values + noise * values.max() * rng.standard_normal(points)
                found = dermis.fit_histories([(times, strains, values)], 2)
            else:
                found = dermis.fit_relaxation(times, values * (1 + noise * rng.standard_normal(points)), 2)
        for e, error, right in zip(pairs(found.elements), pairs(found.errors), pairs(chain)):
            seen = right > 0
            inside += list(np.abs(np.log(np.maximum(e[seen], 1e-99) / right[seen])) <= 2 * error[seen])
    assert 0.92 < np.mean(inside) < 0.98


def ramp(rise, times):
    return 0.1 * np.minimum(1, times / rise)


TIMES = np.concatenate([np.linspace(0, 0.1, 101), np.linspace(0.12, 6, 150)])
WALK = np.cumsum(np.random.default_rng(2).normal(0, 0.01, TIMES.size))


@pytest.mark.parametrize("kind", ["creep", "relaxation"])
def test_a_noisy_curve_has_these_numbers_by_every_scipy(kind):
    wobble = 1 + 0.01 * np.sin(12345.678 * np.arange(60.0))  # a noise that every NumPy makes alike
    curve = relaxation_of(FINGERPAD, T) if kind == "relaxation" else creep_of(dermis.chain_of(FINGERPAD), T)
    found = fit_of(kind, T, curve * wobble)
    np.testing.assert_allclose(pairs(found.elements), NOISY[kind], rtol=2e-6)


NOISY = {"creep": [(1006478.9, 0), (3122594.5, 16040.681), (1581315.2, 164764.6), (487726.22, 1380609.5)],
         "relaxation": [(995029.0, 0), (3229657.5, 17292.906), (1583092.8, 164445.19), (486221.71, 1382326.0)]}


@pytest.mark.parametrize("noise", [0, 0.01])
@pytest.mark.parametrize("kind", ["creep", "relaxation"])
def test_a_fit_without_a_number_takes_as_many_elements_as_the_truth_has_and_says_why(kind, noise):
    chain = dermis.chain_of(FINGERPAD)
    times = np.geomspace(1e-4, 30, 200)
    curve = relaxation_of(FINGERPAD, times) if kind == "relaxation" else creep_of(chain, times)
    found = fit_of(kind, times, curve * (1 + noise * np.random.default_rng(4).standard_normal(times.size)))
    assert len(found.elements) == 4 and found.undetermined == []
    assert found.choice.startswith("4 elements, because 3 leave a residual of ")
    assert fit_of(kind, times, curve, 4).choice == ""


def test_a_fit_says_which_elements_the_data_do_not_need_and_which_they_do_not_fix():
    exact = relaxation_of(FINGERPAD, T)
    assert dermis.fit_relaxation(T, exact, 6).undetermined == [
        "the data take 4 of 6 elements: the others would add nothing"]
    noisy = exact * (1 + 0.01 * np.random.default_rng(3).standard_normal(T.size))
    before = np.inf
    for n in range(1, 9):
        found = dermis.fit_relaxation(T, noisy, n)
        assert found.residual <= before * (1 + 1e-9)
        before = found.residual
        if len(found.elements) > 4:
            assert any(s.startswith("a chain of 4 describes the data as well as one of") for s in found.undetermined)
            assert any(s.startswith("the data hardly fix element") for s in found.undetermined)
    assert "the compliances fall with time, as in no creep" in dermis.fit_creep(T, exact, 3).undetermined
    rising = dermis.fit_relaxation(T, creep_of(dermis.chain_of(FINGERPAD), T), 3)
    assert "the moduli rise with time, as in no relaxation" in rising.undetermined


@pytest.mark.parametrize("strains", [ramp(0.05, TIMES), WALK, np.ones_like(TIMES), np.sin(5 * TIMES)])
def test_the_stress_under_any_strain_gives_the_elements_back(strains):
    found = dermis.fit_histories([(TIMES, strains, stress_of(FINGERPAD, TIMES, strains))])
    np.testing.assert_allclose(pairs(found.elements), pairs(dermis.chain_of(FINGERPAD)), rtol=1e-4)
    np.testing.assert_allclose(found.model, stress_of(FINGERPAD, TIMES, strains), rtol=1e-6, atol=1e-2)


def test_histories_are_fitted_together_each_from_rest_and_two_points_at_one_time_are_a_step():
    slow = (TIMES, ramp(1.0, TIMES), stress_of(FINGERPAD, TIMES, ramp(1.0, TIMES)))
    late = np.concatenate([[0, 1, 1], 1 + np.geomspace(1e-3, 5, 80)])
    step = (late, np.where(np.arange(late.size) < 2, 0, 0.1),
            np.where(np.arange(late.size) < 2, 0, 0.1 * relaxation_of(FINGERPAD, late - 1)))
    for histories in ([slow, step], [step, slow]):
        found = dermis.fit_histories(histories)
        np.testing.assert_allclose(pairs(found.elements), pairs(dermis.chain_of(FINGERPAD)), rtol=1e-4)
        expected = np.concatenate([stress for _, _, stress in histories])
        np.testing.assert_allclose(found.model, expected, rtol=1e-5, atol=1)


@pytest.mark.parametrize("rise, step, fast", [(0.1, 0.002, 0.002), (0.2, 0.004, 0.004)])
def test_a_fit_says_which_times_a_ramp_hides_where_it_misses_a_fast_branch(rise, step, fast):
    truth = dermis.Relaxation(moduli=[4.2e4, 8e4], times=[fast, 0.4], equilibrium=7.8e4)
    times = np.arange(0, 3, step)
    stress = stress_of(truth, times, ramp(rise, times))
    for seed in range(5):
        noise = 0.01 * stress.max() * np.random.default_rng(seed).standard_normal(times.size)
        found = dermis.fit_histories([(times, ramp(rise, times), stress + noise)])
        assert found.elements[0].modulus < 1.7e5 and found.fastest > fast  # the truth is 2e5
        assert found.undetermined[-1].startswith(f"relaxation faster than {found.fastest:.3g} s may hide behind")
    exact = dermis.fit_histories([(times, ramp(rise, times), stress)])
    assert exact.fastest == 0 and exact.undetermined == []
    assert exact.elements[0].modulus == pytest.approx(2e5, rel=1e-3)


def table(path, names, *columns):
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=names, comments="", fmt="%.17g")
    return path


def test_files_are_fitted_as_their_numbers_are_and_a_stress_is_divided_by_its_strain(tmp_path):
    moduli, creep = relaxation_of(FINGERPAD, T), creep_of(dermis.chain_of(FINGERPAD), T)
    of_moduli = pairs(dermis.fit_relaxation(T, moduli).elements)
    for found in (dermis.fit(table(tmp_path / "m.csv", "time,modulus", T, moduli)),
                  dermis.fit([table(tmp_path / "a.csv", "time,stress", T, 0.1 * moduli)] * 2, strain=0.1),
                  dermis.fit(table(tmp_path / "e.csv", "time,E", T, moduli), kind="relaxation"),
                  dermis.fit(table(tmp_path / "c.csv", "time,strain", T, 2e3 * creep), stress=2e3),
                  dermis.fit(table(tmp_path / "h.csv", "time,strain,stress", TIMES, WALK,
                                   stress_of(FINGERPAD, TIMES, WALK)))):
        np.testing.assert_allclose(pairs(found.elements), of_moduli, rtol=1e-5)
    scene = {"time": {"step": 0.1, "duration": 1}, "grid": {"width": 9, "height": 9}}
    material = dermis.Material(elements=dermis.fit(tmp_path / "m.csv").elements)
    by_relaxation = dermis.run(dermis.Scene(scene, material={"relaxation": FINGERPAD}))
    np.testing.assert_allclose(dermis.run(dermis.Scene(scene, material=material))["sa1"].max,
                               by_relaxation["sa1"].max, rtol=1e-6)


@pytest.mark.parametrize("names, options, says", [
    ("time,stress", {}, "stress\"; allowed: stress with --strain, the strain that causes it"),
    ("time,stress", {"kind": "relaxation"}, "stress with --strain"),
    ("time,stress", {"kind": "creep", "stress": 2.0}, "compliance or strain with --kind creep"),
    ("time,load", {"kind": "relaxation"}, "load\"; allowed: stress, which is force over area, in Pa"),
    ("time,force", {"kind": "relaxation", "strain": 0.1}, "force\"; allowed: stress, which is force over area"),
    ("time,modulus", {"strain": 0.1}, "modulus\"; allowed: stress with --strain"),
    ("time,E", {"strain": 0.1}, "any other name with --kind"),
    ("time,stress", {"strain": 0.0}, "strain = 0; allowed: a finite number > 0"),
    ("time (s),modulus (Pa)", {}, "allowed: names without units, as time,modulus"),
    ("time,modulus\n(s),(Pa)", {}, "names take one line, and units none"),
    ("time,modulus", {"kind": "flow"}, "kind = \"flow\"; allowed: \"creep\", \"relaxation\""),
    ("time,modulus", {"n": 0}, "n = 0; allowed: 1 to 8 elements, or None"),
])
def test_a_file_whose_columns_do_not_say_what_they_are_is_refused(tmp_path, names, options, says):
    with pytest.raises(dermis.Error) as caught:
        dermis.fit(table(tmp_path / "a.csv", names, T, relaxation_of(FINGERPAD, T)), **options)
    assert says in str(caught.value)


def test_values_of_0_any_order_and_any_unit_are_taken_with_an_absolute_residual():
    chain = [dermis.KelvinVoigt(modulus=2e6, viscosity=8e3), dermis.KelvinVoigt(modulus=5e5, viscosity=7e5)]
    times = np.append(T, 0)
    creep = creep_of(chain, times)
    with pytest.raises(dermis.Error, match=r"compliances\[60\] = 0; allowed: a finite number > 0; any finite number"):
        dermis.fit_creep(times, creep, 2)
    for unit in (1, 1e9):
        found = dermis.fit_creep(times, creep * unit, 2, "absolute")
        np.testing.assert_allclose(pairs(found.elements) * unit, pairs(chain), rtol=1e-6)


def test_200000_points_are_fitted_as_their_noise_allows():
    times = np.arange(1, 200001) * 5e-5
    exact = relaxation_of(FINGERPAD, times)
    chain = pairs(dermis.chain_of(FINGERPAD))
    np.testing.assert_allclose(pairs(dermis.fit_relaxation(times, exact, 4).elements), chain, rtol=1e-5)
    found = dermis.fit_relaxation(times, exact * (1 + 0.01 * np.random.default_rng(1).standard_normal(times.size)))
    assert found.residual == pytest.approx(0.01, rel=0.01) and found.model.shape == times.shape
    off, errors = np.abs(np.log(pairs(found.elements)[:, 0] / chain[:, 0])), pairs(found.errors)[:, 0]
    assert found.undetermined == [] and (errors < 0.01).all() and (off <= 3 * errors).all()


def test_what_cannot_be_fitted_is_refused_by_name():
    good = [0, 1, 2, 3], [0, 1, 1, 1], [0, 5, 4, 3]
    for call, says in [
            (lambda: dermis.fit_creep([1, 2], [1, 2], 1), "times = 2 numbers; allowed: at least 3 for 1 element"),
            (lambda: dermis.fit_creep([1, 2, 3], [1, 2, 3], 9), "n = 9; allowed: 1 to 8 elements, or None"),
            (lambda: dermis.fit_creep([1, 2, 3], [1, 2, 3], 1, "square"), 'residual = "square"; allowed: "absolute"'),
            (lambda: dermis.fit_creep([1, 2, -3], [1, 2, 3]), "times[2] = -3; allowed: a finite number >= 0"),
            (lambda: dermis.fit_creep([1, 2, 3e60], [1, 2, 3]), "times[2] = 3e+60; allowed: a finite number: 0, or"),
            (lambda: dermis.fit_creep([0, 0, 0], [1, 2, 3]), "times = no time after 0; allowed: at least one"),
            (lambda: dermis.fit_creep([1, 2, 3], [1, 2]), "compliances = 2 numbers; allowed: 3, one for each time"),
            (lambda: dermis.fit_relaxation([1, 2, 3], [-1, -2, -3], 1, "absolute"), "moduli = no number > 0"),
            (lambda: dermis.fit_relaxation([1, 2, 3], [1, np.nan, 3]), "moduli[1] = nan; allowed: a finite number"),
            (lambda: dermis.fit_histories([]), "times = 0 numbers; allowed: at least 3"),
            (lambda: dermis.fit_histories([1, 2]), "histories[0] = 1; allowed: (times, strains, stresses)"),
            (lambda: dermis.fit_histories([good[:2]]), "histories[0] = "),
            (lambda: dermis.fit_histories([(good[0], good[1][:3], good[2])]), "histories[0].strains = 3 numbers"),
            (lambda: dermis.fit_histories([good, ([0, 2, 1], [0, 1, 1], [0, 1, 1])]),
             "histories[1].times[2] = 1; allowed: no time before the one before it"),
            (lambda: dermis.fit_histories([([0, 1, 2], [0, 1, 1], [0, 0, 0])]), "histories = no stress but 0"),
            (lambda: dermis.fit_histories([([1, 1, 1], [0, 1, 1], [0, 1, 1])]), "histories = no time after the first"),
            (lambda: dermis.fit_histories([(np.arange(20001), np.ones(20001), np.ones(20001))]),
             "histories = 20001; allowed: at most 20000 points in all"),
            (lambda: dermis.fit("none.csv"), "none.csv: cannot be read"),
            (lambda: dermis.Scene(material={"relaxation_file": "a.csv"}), "dermis fit FILE prints the table [material]")]:
        with pytest.raises(dermis.Error) as caught:
            call()
        assert says in str(caught.value) and caught.value.code == "bad_input"


def test_without_scipy_a_fit_names_the_package(monkeypatch):
    monkeypatch.delitem(sys.modules, "dermis._fit", raising=False)
    monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    with pytest.raises(ModuleNotFoundError, match=r"fit needs scipy.optimize: pip install dermis\[fit\]"):
        dermis.fit_creep([1, 2, 3], [1, 2, 3])

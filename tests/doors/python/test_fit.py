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

# SPDX-License-Identifier: MIT
"""The blocks of host/examples/SPIKES_INTO.md run, and a network gets the spikes of the skin. `./run trust networks`."""
import pathlib
import re

import dermis
import numpy as np
import pytest

PAGE = pathlib.Path(__file__).parents[3] / "host/examples/SPIKES_INTO.md"
FIRST, *BLOCKS = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.M | re.S)
BRIAN2, SNNTORCH, GYMNASIUM = BLOCKS


def run(block):
    names = {}
    exec(FIRST + block, names)
    return names


@pytest.fixture(scope="module")
def of_skin():
    """The counts of each frame of the page, by a skin that no network reads."""
    names = run("skin, counts = dermis.Skin(scene, afferents=afferents), []\n"
                "for frame in pressure: skin.press(frame, 1e-3); counts.append(skin.spike_counts())")
    assert {*names["skin"].fibres} == {"sa1", "fa1", "fa2"}
    assert all(np.sum(names["counts"], 0)[names["skin"].fibres == kind].any() for kind in ("sa1", "fa1", "fa2"))
    return np.array(names["counts"])


def test_brian2_gets_every_spike_once_at_its_time(of_skin):
    import brian2 as b2
    b2.prefs.codegen.target = "numpy"
    watched = BRIAN2.replace("network = b2.Network(", "heard = b2.SpikeMonitor(source)\nnetwork = b2.Network(heard, ")
    assert watched != BRIAN2
    names = run(watched)
    heard = names["heard"]
    assert heard.num_spikes == of_skin.sum() > 100 and names["seen"].num_spikes > 10
    for fibre in range(of_skin.shape[1]):
        assert np.bincount(np.asarray(heard.i), minlength=of_skin.shape[1])[fibre] == of_skin[:, fibre].sum()
    by_frame = np.bincount(np.floor(np.asarray(heard.t) / 1e-3 + 1e-6).astype(int), minlength=200)
    assert abs(by_frame - of_skin.sum(1)).sum() <= 0.02 * of_skin.sum()  # one at the end of a frame may be in the next


def test_snntorch_gets_the_counts_of_each_tip(of_skin):
    names = run(SNNTORCH)
    assert np.array_equal(names["counts"].numpy(), np.broadcast_to(of_skin[-1], (8, 2, 48)))
    assert names["total"].shape == (8, 2, 10) and names["total"].sum() > 0


def test_a_wrapper_of_gymnasium_observes_fibres(of_skin):
    import gymnasium
    from gymnasium.utils.env_checker import check_env
    names = run(GYMNASIUM)

    class Pressed(gymnasium.Env):
        """The page's pressures, one after another."""
        observation_space = gymnasium.spaces.Box(0, np.inf, (32, 32), np.float32)
        action_space = gymnasium.spaces.Discrete(2)

        def reset(self, *, seed=None, options=None):
            super().reset(seed=seed)
            self.frame = 0
            return names["pressure"][0], {}

        def step(self, action):
            self.frame += 1
            return names["pressure"][self.frame], 0.0, self.frame == 199, False, {}

    felt = names["Felt"](Pressed(), dermis.Skin(names["scene"], afferents=names["afferents"]), 1e-3)
    check_env(felt, skip_render_check=True)
    for _ in range(2):  # a second episode begins at rest
        observed, _ = felt.reset()
        ended, seen = False, [observed]
        while not ended:
            observed, _, ended, *_ = felt.step(0)
            seen.append(observed)
        assert np.array_equal(seen, of_skin) and felt.observation_space.contains(observed)

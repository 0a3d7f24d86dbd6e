# SPDX-License-Identifier: MIT
"""What the files of the page EVIDENCE.md have in common: a row, the papers, the data, a run of dermis, a picture."""
import csv
import subprocess
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import drawing

HERE = Path(__file__).parent
DATA = HERE / "evidence"
# The papers, by what rows and the first lines of data files call them.
SOURCES = {
    "Bensmaia et al. 2005": "S. J. Bensmaia, J. C. Craig, T. Yoshioka and K. O. Johnson, SA1 and RA afferent responses to "
    "static and vibrating gratings, J. Neurophysiol. 95 (2006) 1771-1782, online 2005, doi:10.1152/jn.00877.2005",
    "Connor et al. 1990": "C. E. Connor, S. S. Hsiao, J. R. Phillips and K. O. Johnson, Tactile roughness: neural codes that "
    "account for psychophysical magnitude estimates, J. Neurosci. 10 (1990); its abstract was seen, the rates as digitized by "
    "Ouyang et al. 2021",
    "Essick and Edin 1995": "G. K. Essick and B. B. Edin, Receptor encoding of moving tactile stimuli in humans. II. The "
    "mean response of individual low-threshold mechanoreceptors to motion across the receptive field, J. Neurosci. 15 "
    "(1995); its abstract was seen",
    "Freeman and Johnson 1982": "A. W. Freeman and K. O. Johnson, A model accounting for effects of vibratory "
    "amplitude on responses of cutaneous mechanoreceptors in macaque monkey, J. Physiol. 323 (1982) 43-64, "
    "doi:10.1113/jphysiol.1982.sp014060",
    "Goodwin et al. 1995": "A. W. Goodwin, A. S. Browning and H. E. Wheat, Representation of curved surfaces in responses of "
    "mechanoreceptive afferent fibers innervating the monkey's fingerpad, J. Neurosci. 15 (1995); not seen",
    "Hay and Pruszynski 2020": "E. Hay and J. A. Pruszynski, Orientation processing by synaptic integration across "
    "first-order tactile neurons, PLoS Comput. Biol. 16 (2020) e1008303, doi:10.1371/journal.pcbi.1008303",
    "Jarocka et al. 2021": "E. Jarocka, J. A. Pruszynski and R. S. Johansson, Human touch receptors are sensitive to "
    "spatial details on the scale of single fingerprint ridges, J. Neurosci. 41 (2021) 3622-3634, "
    "doi:10.1523/JNEUROSCI.1716-20.2021",
    "Mei et al. 1983": "J. Mei, R. P. Tuckett, D. A. Poulos, K. W. Horch, J. Y. Wei and P. R. Burgess, The neural "
    "signal for skin indentation depth. II. Steady indentations, J. Neurosci. 3 (1983) 2652-2659, "
    "doi:10.1523/JNEUROSCI.03-12-02652.1983",
    "Muniak et al. 2007": "M. A. Muniak, S. Ray, S. S. Hsiao, J. F. Dammann and S. J. Bensmaia, The neural coding of "
    "stimulus intensity: linking the population response of mechanoreceptive afferents with psychophysical behavior, "
    "J. Neurosci. 27 (2007) 11687-11699, doi:10.1523/JNEUROSCI.1486-07.2007",
    "Ouyang et al. 2021": "Q. Ouyang, J. Wu, Z. Shao, D. Chen and J. W. Bisley, A simplified model for simulating "
    "population responses of tactile afferents and receptors in the skin, IEEE Trans. Biomed. Eng. 68 (2021) 556-567, "
    "doi:10.1109/TBME.2020.3007397",
    "Phillips and Johnson 1981": "J. R. Phillips and K. O. Johnson, Tactile spatial resolution. II. Neural "
    "representation of bars, edges, and gratings in monkey primary afferents, J. Neurophysiol. 46 (1981) 1192-1203, "
    "doi:10.1152/jn.1981.46.6.1192",
    "Saal et al. 2017": "H. P. Saal, B. P. Delhaye, B. C. Rayhaun and S. J. Bensmaia, Simulating tactile signals from "
    "the whole hand with millisecond precision, PNAS 114 (2017) E5693-E5702, doi:10.1073/pnas.1704856114",
    "Scheibert et al. 2009": "J. Scheibert, S. Leurent, A. Prevost and G. Debrégeas, The role of fingerprints in the "
    "coding of tactile information probed with a biomimetic sensor, Science 323 (2009) 1503-1506, "
    "doi:10.1126/science.1166467",
    "Vega-Bermudez and Johnson 1999": "F. Vega-Bermudez and K. O. Johnson, SA1 and RA receptive fields, response "
    "variability, and population responses mapped with a probe array, J. Neurophysiol. 81 (1999) 2701-2710, "
    "doi:10.1152/jn.1999.81.6.2701",
}
ROW_OF_CELLS = """
[grid]
width = {width}
height = 1
spacing = 1e-3
[surface]
kind = "flat"
relief = 1e-5
[material]
modulus = 1 # Pa: the strain is the pressure
viscosity = 0
thickness = 1e-3
curvature_length = 0
[load]
path = "strains.npy"
{load}
{afferents}
[time]
step = {step}
duration = {duration}
[output]
traces = []
"""


@dataclass
class Row:
    """What a row's function computes; the texts are Markdown. numbers: those that rows.csv judges, and others, which are
    compared with the expected numbers alone."""
    ours: str  # in words
    why: str
    numbers: dict
    picture: str = ""


def data(name):
    """The rows of a file of published numbers."""
    return list(csv.DictReader(line for line in lines_of(name) if not line.startswith("#")))


def lines_of(name):
    return (DATA / name).read_text().splitlines()


def run(dermis, scene, folder, *settings):
    """The folder of the results of a scene. What dermis says stops the script if it refuses the scene."""
    Path(folder, "scene.toml").write_text(scene)
    done = subprocess.run([dermis, "run", f"{folder}/scene.toml", "--out", f"{folder}/out", *settings],
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode:
        raise RuntimeError(f"{dermis} run ended with {done.returncode}: {done.stderr.strip()}")
    return Path(folder, "out")


def fire(dermis, strains, load, duration, tables, interval=None):
    """The times (s) of the spikes of afferents that strains drive: each one a cell's value times the load's envelope.

    tables: the text of each [[afferents]] table and the numbers of its cells. Afferents are in the order of the tables.
    interval: if strains has a row of cells for each time, the s between them.
    """
    texts = ["[[afferents]]\n" + text + f"\ncells = {[[int(cell), 0] for cell in cells]}\n" for text, cells in tables]
    frames = np.atleast_2d(np.asarray(strains, float))[:, None, :]
    kind = 'kind = "file"' if interval is None else f'kind = "sequence"\ninterval = {float(interval)}'
    scene = ROW_OF_CELLS.format(width=frames.shape[2], load=f"{kind}\n{load}", duration=float(duration),
                                step=float(interval or 0.01), afferents="".join(texts))
    with tempfile.TemporaryDirectory() as folder:
        np.save(f"{folder}/strains.npy", frames if interval else frames[0])
        spikes = np.load(run(dermis, scene, folder) / "spikes.npy")
    return [spikes["time"][spikes["afferent"] == n] for n in range(sum(len(cells) for _, cells in tables))]


def save(figure, picture):
    for axis in figure.axes:
        axis.tick_params(labelsize=8)
        axis.grid(alpha=0.3)
    drawing.save(figure, picture)

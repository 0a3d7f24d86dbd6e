# SPDX-License-Identifier: MIT
"""What the files of the page EVIDENCE.md have in common: a row, the papers, the data, a run of dermis, a picture."""
import csv
import subprocess
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import matplotlib
matplotlib.use("Agg")
import numpy as np
from PIL import Image  # matplotlib's own requirement

HERE = Path(__file__).parent
DATA = HERE / "evidence"
BLUE, VERMILLION, GREEN, GREY = "#0072B2", "#D55E00", "#009E73", "#888888"
# The papers, by what rows and the first lines of data files call them.
SOURCES = {
    "Freeman and Johnson 1982": "A. W. Freeman and K. O. Johnson, A model accounting for effects of vibratory "
    "amplitude on responses of cutaneous mechanoreceptors in macaque monkey, J. Physiol. 323 (1982) 43-64, "
    "doi:10.1113/jphysiol.1982.sp014060",
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
    "Pawluk and Howe 1999": "D. T. V. Pawluk and R. D. Howe, Dynamic lumped element response of the human fingerpad, "
    "J. Biomech. Eng. 121 (1999) 178-183, doi:10.1115/1.2835100",
    "Phillips and Johnson 1981": "J. R. Phillips and K. O. Johnson, Tactile spatial resolution. II. Neural "
    "representation of bars, edges, and gratings in monkey primary afferents, J. Neurophysiol. 46 (1981) 1192-1203, "
    "doi:10.1152/jn.1981.46.6.1192",
    "Saal et al. 2017": "H. P. Saal, B. P. Delhaye, B. C. Rayhaun and S. J. Bensmaia, Simulating tactile signals from "
    "the whole hand with millisecond precision, PNAS 114 (2017) E5693-E5702, doi:10.1073/pnas.1704856114",
    "Scheibert et al. 2009": "J. Scheibert, S. Leurent, A. Prevost and G. Debrégeas, The role of fingerprints in the "
    "coding of tactile information probed with a biomimetic sensor, Science 323 (2009) 1503-1506, "
    "doi:10.1126/science.1166467",
    "Wang et al. 2015": "Y. Wang, K. L. Marshall, Y. Baba, E. A. Lumpkin and G. J. Gerling, Compressive "
    "viscoelasticity of freshly excised mouse skin is dependent on specimen thickness, strain level and rate, "
    "PLoS ONE 10 (2015) e0120897, doi:10.1371/journal.pone.0120897",
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
kind = "file"
path = "strains.npy"
{load}
{afferents}
[time]
step = 0.01
duration = {duration}
[output]
traces = []
"""


@dataclass
class Row:
    """A row of the page; the texts are Markdown."""
    title: str
    published: str
    ours: str
    agrees: bool
    why: str
    scene: str
    source: str  # a paper by its key in SOURCES, or a link to a file's lines under Data
    numbers: dict = field(default_factory=dict)  # what is compared with the expected numbers
    picture: str = ""

    @property
    def verdict(self):
        return "agrees" if self.agrees else "**fails**"


def data(name, papers):
    """The rows of a file of published numbers, and its papers with a link to what its first lines say, under Data."""
    rows = csv.DictReader(line for line in lines_of(name) if not line.startswith("#"))
    return list(rows), f"{papers}, [{name}](#data)."


def lines_of(name):
    return (DATA / name).read_text().splitlines()


def run(dermis, scene, folder, *settings):
    Path(folder, "scene.toml").write_text(scene)
    subprocess.run([dermis, "run", f"{folder}/scene.toml", "--out", f"{folder}/out", *settings], check=True,
                   stdout=subprocess.DEVNULL)
    return Path(folder, "out")


def fire(dermis, strains, load, duration, tables):
    """The times (s) of the spikes of afferents that strains drive: each one a cell's value times the load's envelope.

    tables: the text of each [[afferents]] table and the numbers of its cells. Afferents are in the order of the tables.
    """
    texts = ["[[afferents]]\n" + text + f"\ncells = {[[int(cell), 0] for cell in cells]}\n" for text, cells in tables]
    scene = ROW_OF_CELLS.format(width=len(strains), load=load, duration=duration, afferents="".join(texts))
    with tempfile.TemporaryDirectory() as folder:
        np.save(f"{folder}/strains.npy", np.array(strains, float)[None, :])
        spikes = np.load(run(dermis, scene, folder) / "spikes.npy")
    return [spikes["time"][spikes["afferent"] == n] for n in range(sum(len(cells) for _, cells in tables))]


def save(figure, picture):
    for axis in figure.axes:
        axis.tick_params(labelsize=8)
        axis.grid(alpha=0.3)
    figure.canvas.draw()
    image = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3])
    image.quantize(256, Image.Quantize.MAXCOVERAGE).save(picture, optimize=True)

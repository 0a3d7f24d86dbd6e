# SPDX-License-Identifier: MIT
"""Error against time, and the stability of methods: runs of closed_form.toml and stability.toml, as tables."""
import io

import numpy as np

STEPS = [0.64 / 2**k for k in range(7)]  # s
METHODS = ["euler", "rk2", "rk4", "backward-euler", "crank-nicolson", "sdirk2", "exact"]
LADDER = 10 ** (np.arange(-30, 31) / 5)  # z, the step over the retardation time
FAILURES = {"euler": 2.1, "rk2": 2.1, "crank-nicolson": 20, "sdirk2": 8.24, "backward-euler": 8.24, "exact": 8.24}  # z
CELLS = [*LADDER, *sorted(set(FAILURES.values()))]  # the z of each cell of stability.toml


def error_against_time(r, vulkan):
    """Writes the greatest errors of the most strained cell over all outputs, by the greatest value of the closed form. Each
    step is run three times, one after the other: the first also warms up, and the fastest counts."""
    lines = ["method,precision,device,step,steps,error_strain,error_fa1,ns_per_cell_step,ns_per_cell_second"]
    steps, rate = ",".join(f"{step!r}" for step in STEPS for _ in range(3)), 1.54  # modulus over viscosity
    for device, precision in [("cpu", "f32"), ("cpu", "f64")] + [("vulkan", "f32")] * vulkan:
        folder = r.run(f"chart/{device}_{precision}", "closed_form.toml", ["method=euler,exact", f"time.step={steps}"],
                       device, precision)
        rows = r.table(f"{folder}/runs.csv")
        for alike in (rows[i:i + 3] for i in range(0, len(rows), 3)):
            run = f"{folder}/{alike[0]['run']}"
            traces, taken = r.traces(run), r.summary(run)["steps"]
            time = traces["time"][1:]
            strain = np.abs(traces["strain_max"][1:] + np.expm1(-rate * time) / rate).max() * rate
            fa1 = np.abs(traces["fa1_max"][1:] - np.exp(-rate * time)).max()
            cell = min(1e9 * float(row["seconds"]) for row in alike) / 150**2  # ns
            lines.append(",".join(map(str, [alike[0]["method"], precision, device, alike[0]["time.step"], taken, strain, fa1,
                                            cell / taken, cell / 2.56])))
    r.write("chart.csv", "\n".join(lines) + "\n")


def stability(r):
    """Writes the greatest error of the strain under a held load within 3/z steps, at least 50 and at most 3000; and the
    strains of the first 12 steps where methods fail."""
    viscosities = io.BytesIO()
    np.save(viscosities, 1 / np.array([CELLS]))
    r.write("stability/viscosity.npy", viscosities.getvalue())
    settings = [f"grid.width={len(CELLS)}", f"output.probes={[[x, 0] for x in range(len(CELLS))]}",
                f"material.viscosity='{(r.out / 'stability/viscosity.npy').resolve()}'"]
    errors, courses = ["method,precision,z,steps,error"], ["method,z,step,strain"]
    for method, precision in [(method, "f64") for method in METHODS] + [("exact", "f32")]:
        traces = r.traces(r.run(f"stability/{method}_{precision}", "stability.toml", [f"method={method}", *settings],
                                precision=precision))
        for cell, z in enumerate(LADDER):
            steps = int(np.clip(np.ceil(3 / z), 50, 3000))
            error = np.abs(traces[f"strain_probe{cell}"][:steps + 1] + np.expm1(-z * np.arange(steps + 1))).max()
            errors.append(f"{method},{precision},{z},{steps},{error if np.isfinite(error) else 'inf'}")
        if precision == "f64" and method in FAILURES:
            strain = traces[f"strain_probe{CELLS.index(FAILURES[method])}"][:13]
            courses += [f"{method},{FAILURES[method]},{n},{value}" for n, value in enumerate(strain)]
    r.write("stability.csv", "\n".join(errors) + "\n")
    r.write("failures.csv", "\n".join(courses) + "\n")

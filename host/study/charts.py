# SPDX-License-Identifier: MIT
"""Error against time: runs of closed_form.toml, as a table."""
import numpy as np

STEPS = [0.64 / 2**k for k in range(7)]  # s


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

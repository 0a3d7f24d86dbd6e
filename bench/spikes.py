# SPDX-License-Identifier: MIT
"""Spike times of afferents under a sine from rest against the step and its cost, by dermis and as others take them, beside
a reference without steps.

    spikes.py dermis [picture.png results.csv]

Costs are those of a run of dermis-bench. The functions of other methods take an afferent model as a dictionary, whose keys
are the members of AfferentModel, and q's amplitude, frequency (Hz) and duration (s): q = amplitude*sin(2*pi*hz*t). Each
returns spike times in s.
"""
import csv
import json
from pathlib import Path

import numpy as np
from scipy import signal
from scipy.linalg import expm

from drawing import BLUE, GREEN, ORANGE, PURPLE, chart, figure, key, logarithmic, rule, save
from runs import afferent, fire

COARSE, HALVINGS = 2.0**-15, 32  # s: the reference's longest step, and how often it is halved: to 7e-15 s


def low_pass(model):
    """Coefficients of F's denominator in s, the highest power first."""
    factors = [np.array([time, 1]) for time in model["time_constants"]]
    if model.get("frequency") is not None:
        w = 2 * np.pi * model["frequency"]
        factors.append(np.array([1 / w**2, 1 / (model["quality"] * w), 1]))
    result = np.ones(1)
    for factor in factors:
        result = np.polymul(result, factor)
    return result


def companion(model):
    """A and b of x' = A*x + b*w, where x holds y and its derivatives."""
    coefficients = low_pass(model)
    matrix = np.eye(len(coefficients) - 1, k=1)
    matrix[-1] = -coefficients[:0:-1] / coefficients[0]
    column = np.zeros(len(matrix))
    column[-1] = 1 / coefficients[0]
    return matrix, column


def current(model, y):
    """I of y and its derivatives, which may be arrays."""
    return sum(gains[0] * np.maximum(x, 0) + gains[1] * np.maximum(-x, 0) for gains, x in zip(model["gains"], y))


def input_at(model, amplitude, hz, time):
    w = 2 * np.pi * hz
    return amplitude * (model["value"] * np.sin(w * time) + model["rate"] * w * np.cos(w * time))


def membrane(model, driven, dt, leak):
    """Spikes of V <- V + leak*(I + after - V) on a grid, for the currents I of the steps that end at dt, 2*dt, ..."""
    wait = round(model["refractory_time"] / dt)
    spikes, voltage, since = [], 0.0, None
    for i, now in enumerate(driven):
        if since is not None:
            since += 1
            if since <= wait:
                continue
            now += sum(a * np.exp(-(since - 1) * dt / time) for a, time in model["after"] if a)
        voltage += leak * (now - voltage)
        if voltage >= 1:
            spikes.append((i + 1) * dt)
            voltage, since = model["reset"], 0
    return np.array(spikes)


def euler(model, amplitude, hz, seconds, dt):
    """Forward Euler for the filter and the membrane."""
    matrix, column = companion(model)
    x, driven = np.zeros(len(matrix)), []
    with np.errstate(over="ignore", invalid="ignore"):  # a step too long for the filter grows without bound
        for i in range(round(seconds / dt)):
            driven.append(current(model, x))
            x = x + dt * (matrix @ x + column * input_at(model, amplitude, hz, i * dt))
        return membrane(model, driven, dt, dt / model["membrane_time"])


def backward_euler(model, amplitude, hz, seconds, dt):
    """Backward Euler for the filter and forward Euler for the membrane, as Ouyang et al. (2021) take them."""
    matrix, column = companion(model)
    solve = np.linalg.inv(np.eye(len(matrix)) - dt * matrix)
    x, driven = np.zeros(len(matrix)), []
    for i in range(round(seconds / dt)):
        x = solve @ (x + dt * column * input_at(model, amplitude, hz, (i + 1) * dt))
        driven.append(current(model, x))
    return membrane(model, driven, dt, dt / model["membrane_time"])


def touchsim_recursion(model, amplitude, hz, seconds, dt):
    """TouchSim's method (Saal et al. 2017): a bilinear filter of the input and of its central difference, a forward
    difference for y'', and V <- V - V/n + I, whose n gives the membrane's decay in a step exactly.

    A spike's time is that of the sample that shows it. TouchSim itself reports it one step later.
    """
    w = input_at(model, amplitude, hz, np.arange(round(seconds / dt) + 2) * dt)
    speed = np.append(w[1:], 0) - np.append(0, w[:-1])
    warped = 1 / dt  # so that the filter is exact at the frequency of its pair
    if model.get("frequency") is not None:
        warped = np.pi * model["frequency"] / np.tan(np.pi * model["frequency"] * dt)
    filtered = signal.bilinear([1], low_pass(model), warped)
    rate = signal.lfilter(*filtered, speed / (2 * dt))[:-1]
    y = signal.lfilter(*filtered, w)[:-2], rate[:-1], np.diff(rate) / dt
    driven = current(model, y)[1:]  # that of the first sample acts before the start
    return membrane(model, driven, dt, -np.expm1(-dt / model["membrane_time"]))


def reference(model, amplitude, hz, seconds, longest=COARSE):
    """Matrix exponentials of the filter, the sine, V and the after-currents; steps end where V or a sign turns.

    State: x, amplitude*sin, amplitude*cos, the two after-currents, V. A step that V or a sign of x does not survive is
    halved. What turns and returns within the longest step is not seen.
    """
    matrix, column = companion(model)
    n, w = len(matrix), 2 * np.pi * hz
    flow = np.zeros((n + 5, n + 5))
    flow[:n, :n] = matrix
    flow[:n, n] = column * model["value"]
    flow[:n, n + 1] = column * model["rate"] * w
    flow[n, n + 1], flow[n + 1, n] = w, -w
    for i, (_, time) in enumerate(model["after"]):
        flow[n + 2 + i, n + 2 + i] = -1 / time
    steps = [longest * 0.5**i for i in range(HALVINGS + 1)]
    held = [expm(flow * h) for h in steps]  # V at rest: what it does not act on
    refractory = expm(flow * model["refractory_time"])
    free = {}

    def advance(signs, level):
        if (signs, level) not in free:
            row = np.zeros(n + 5)
            row[:n] = [gains[0] if s > 0 else -gains[1] for gains, s in zip(model["gains"], signs)]
            row[n + 2:] = 1, 1, -1
            moved = flow.copy()
            moved[-1] = row / model["membrane_time"]
            free[signs, level] = expm(moved * steps[level])
        return free[signs, level]

    state, time, spikes = np.zeros(n + 5), 0.0, []
    state[n + 1] = amplitude
    while time < seconds:
        for level in range(HALVINGS + 1):
            end = held[level][:n] @ state
            turned = np.any(state[:n] * end < 0)
            if turned and level < HALVINGS:
                continue
            after = advance(tuple(np.where(end != 0, end, state[:n]) > 0), level) @ state
            if after[-1] < 1 or level == HALVINGS:
                break
        state, time = after, time + steps[level]
        if state[-1] >= 1:
            spikes.append(time)
            state[-1] = model["reset"]
            state[n + 2:-1] = [a for a, _ in model["after"]]
            state, time = refractory @ state, time + model["refractory_time"]
    return np.array([s for s in spikes if s <= seconds])


def match(spikes, wanted, within):
    """Errors (s) of the spikes that have a wanted one within `within` seconds, each the other's nearest; the number of
    wanted spikes that are lost, and of spikes that are invented."""
    if len(spikes) == 0 or len(wanted) == 0:
        return np.zeros(0), len(wanted), len(spikes)
    apart = spikes[None, :] - wanted[:, None]
    nearest = np.argmin(np.abs(apart), axis=1)
    mutual = np.argmin(np.abs(apart), axis=0)[nearest] == np.arange(len(wanted))
    errors = apart[np.arange(len(wanted)), nearest]
    errors = errors[mutual & (np.abs(errors) <= within)]
    return errors, len(wanted) - len(errors), len(spikes) - len(errors)


# A frequency and an amplitude at which the afferent of each class fires well.
CASES = {"SA1, 10 Hz": (10, 3.0, afferent("sa1")), "FA1 (RA), 50 Hz": (50, 0.25, afferent("ra")), "FA2 (PC), 250 Hz": (250, 2.5e-4, afferent("pc"))}
STEPS = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4)
SECONDS = 1.0
FRAMES, SINE = "dermis, by frames", "dermis, given the sine"
METHODS = {  # how, a colour, a marker, and the row of dermis-bench that has the cost of a step
    "forward Euler": (euler, ORANGE, "o", "integrate-and-fire"),
    "backward Euler filter\n(Ouyang et al. 2021)": (backward_euler, PURPLE, "s", "ouyang"),
    "TouchSim's recursion\n(Saal et al. 2017)": (touchsim_recursion, GREEN, "^", "touchsim"),
    FRAMES: (None, BLUE, "D", None), SINE: (None, "black", "*", None)}


def dermis(program, model, amplitude, hz, step, frames):
    """Spike times of a run. frames: whether the sine is known by frames, with straight lines between them."""
    keys = {"type": "sa1", **model, "after": []}
    text = "\n".join(f"{key} = {json.dumps(value)}" for key, value in keys.items())
    if frames:
        values = amplitude * np.sin(2 * np.pi * hz * step * np.arange(round(SECONDS / step) + 1))
        return fire(program, values[:, None], "", SECONDS, [(text, [0])], interval=step)[0]
    load = f'envelope = "sine"\nmean = 0\nfrequency = {hz}'
    return fire(program, [amplitude], load, SECONDS, [(text, [0])], step=step)[0]


def measured(program):
    """For each case its number of spikes, and for each method the median error (s), lost and invented at each step."""
    program, found = str(Path(program).resolve()), {}
    for title, (hz, amplitude, model) in CASES.items():
        wanted = reference(model, amplitude, hz, SECONDS)
        within = np.diff(wanted).min() / 2
        rows = {}
        for method, (f, *_) in METHODS.items():
            rows[method] = []
            for step in STEPS:
                spikes = f(model, amplitude, hz, SECONDS, step) if f else dermis(program, model, amplitude, hz, step, method == FRAMES)
                errors, lost, invented = match(spikes, wanted, within)
                rows[method].append((np.median(np.abs(errors)) if len(errors) else np.nan, lost, invented))
        found[title] = len(wanted), {method: np.array(values) for method, values in rows.items()}
    return found


def claims(found):
    wrong = {(case[:3], method): (values[:, 1] + values[:, 2]) / count for case, (count, rows) in found.items()
             for method, values in rows.items()}
    median = {(case[:3], method): values[:, 0] for case, (_, rows) in found.items() for method, values in rows.items()}
    others = [method for method in METHODS if method not in (FRAMES, SINE)]
    return {"given the sine, dermis has every spike and none more at every step up to 10 ms": all(
        not wrong[case[:3], SINE].any() for case in CASES),
        "half of them to 0.2 us": all(np.nanmax(median[case[:3], SINE]) < 2e-7 for case in CASES),
        "by frames it has every spike to steps of 10 ms (SA1, 10 Hz), 5 ms (FA1, 50 Hz) and 1 ms (FA2, 250 Hz)": not any(
            wrong[case, FRAMES][STEPS.index(step):].any() for case, step in (("SA1", 1e-2), ("FA1", 5e-3), ("FA2", 1e-3))),
        "and none at twice the last two steps, from which no frame tells of the sine": all(
            wrong[case, FRAMES][STEPS.index(step)] == 1 for case, step in (("FA1", 1e-2), ("FA2", 2e-3))),
        "at steps of 5 and 10 ms every other method loses or invents 60 % and more of every class": all(
            (wrong[case[:3], method][:2] >= 0.6).all() for case in CASES for method in others),
        "at 1 ms forward Euler loses and invents more spikes of FA1 than there are, backward Euler has none of FA2, TouchSim's "
        "recursion loses a third of FA1": wrong["FA1", others[0]][3] > 1 and wrong["FA2", others[1]][3] == 1
        and abs(wrong["FA1", others[2]][3] - 1 / 3) < 0.01}


def costs(rows):
    """ns of one thread for a fibre and simulated second, by method at each step: rows of dermis-bench."""
    def ns(row):
        return 1e9 * float(row["wall_least_s"]) / float(row["steps"]) / float(row["receptors"]) * max(int(row["threads"]), 1)
    by_step = {float(r["method"]): ns(r) for r in rows if r["workload"] == "spikes-steps"}
    a_step = {r["method"]: ns(r) for r in rows if r["workload"] == "spikes" and r["wall_least_s"]}
    return {method: np.array([(by_step.get(step, np.nan) if row is None else a_step.get(row, np.nan)) / step for step in STEPS])
            for method, (_, _, _, row) in METHODS.items()}


def draw(found, picture, table):
    with open(table, newline="") as file:
        cost = costs(list(csv.DictReader(file)))
    drawn, axes = figure(2, 3, 5.8, "Given the load, dermis has each spike at any step; others lose and invent", sharex=True, sharey="row")
    for (top, below), (title, (count, rows)) in zip(axes.T, found.items()):
        logarithmic(top)
        logarithmic(below, y=False)
        for method, values in rows.items():
            _, colour, mark, _ = METHODS[method]
            error, wrong = values[:, 0] * 1e3, 100 * (values[:, 1] + values[:, 2]) / count
            top.plot(cost[method], np.maximum(error, 1e-9), marker=mark, color=colour)
            below.plot(cost[method], np.minimum(wrong, 200), marker=mark, color=colour)
        rule(top, 1e-3, "float: 1 us" if title.startswith("SA1") else "", "left")
        top.set(title=f"{title}: {count} spikes", ylim=(1e-7, 100))
        below.set(xlabel="ns a fibre and second\n(steps of 10 to 0.1 ms)", ylim=(-5, 210))
        below.set_yticks((0, 50, 100, 150, 200), ("0", "50", "100", "150", "200+"))
    axes[0, 0].set_ylabel("median error of a time (ms)")
    axes[1, 0].set_ylabel("lost and invented (%)")
    key(drawn, *zip(*[(axes[0, 0].plot([], [], marker=m, color=c)[0], name) for name, (_, c, m, _) in METHODS.items()]), 0.1, ncol=5)
    save(drawn, picture)


if __name__ == "__main__":
    chart(measured, claims, draw)

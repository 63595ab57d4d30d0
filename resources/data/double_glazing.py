"""Air between two sheets of glass, one warm, one cold: the data set behind the networks of thesis chapter 5.

    python resources/data/double_glazing.py          writes networks/data/double-glazing.vti
    python resources/data/double_glazing.py start    writes networks/data/glazing-start-0.vti and on, second by second

The air of a closed gap rises along the warm sheet (x = 0) and falls along the cold one. Solved are the equations of
Navier and Stokes with Boussinesq's buoyancy and the transport of heat,

    du/dt + div(u u) = -grad p + Pr lap u + Ra Pr T e_z,    div u = 0,    dT/dt + div(u T) = lap T,

in units of the width L of the gap, the conductivity k of temperature and the difference between the sheets; walls do
not slip, and those that are no sheets let no heat through. Finite volumes on a staggered lattice, central and of second
order, march to a steady state; the pressure comes from a cosine transform.

Checked (`benchmark`) against the square cavity of G. de Vahl Davis, Natural convection of air in a square cavity: a
bench mark numerical solution, Int. J. Numer. Methods Fluids 3 (1983) 249-264, Pr = 0.71: largest horizontal velocity on
the vertical mid-line, largest vertical velocity on the horizontal one, and mean Nusselt number.

    Ra      u max    v max    Nu             here, 40 x 40 cells
    1e3     3.649    3.697    1.118          3.657    3.705    1.119
    1e4     16.178   19.617   2.243          16.179   19.673   2.260
    1e5     34.73    68.59    4.519          34.92    69.16    4.623

The file holds 18 x 10 x 10 nodes [z, y, x] with velocity (mm/s), temperature (degrees Celsius) and pressure (mPa, less
the hydrostatic one) as float32. By the difference to cells twice as wide, divided by 3 as of second order, the
discretisation leaves about 0.3 mm/s of at most 33 mm/s, 0.09 of 14 degrees and 0.02 of 3.2 mPa.

The files of the start hold the velocity alone, on its way to that state: air at rest that only conducts heat, let go at 0 s.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn, idctn

Floats = NDArray[np.float64]

PRANDTL = 0.71
RAYLEIGH = 1e4
"""Of the data set: 18 mm of air between sheets 14 degrees apart."""

GAP = 18.0
"""mm"""
CONDUCTIVITY = 20.0
"""Of temperature, in air, mm^2/s."""
DENSITY = 1.25
"""Of air, kg/m^3; times (mm/s)^2 it is a pressure in uPa."""
WARM, COLD = 17.0, 3.0
"""Degrees Celsius."""
NODES = (18, 10, 10)
"""Along z, y, x: 2 mm apart."""
FINER = 4
"""Cells of the solver between two nodes."""

SECONDS = (0.0, 1.0, 2.0, 3.0, 4.0)
"""Of the files of the start."""

STEADY = 1e-4
"""Largest change of the velocity in a unit of time, as a part of the largest velocity, that counts as steady."""


@dataclass
class State:
    """Temperature and pressure in cells, each component of the velocity on the faces across it; axes z[, y], x.

    Parameters
    ----------
    time : in units of L^2 / k
    """

    h: float
    velocity: list[Floats]
    temperature: Floats
    pressure: Floats
    time: float = 0.0


def solve(cells: tuple[int, ...], rayleigh: float = RAYLEIGH, *, longest: float = 4.0) -> State:
    """The steady convection in a box of cells (along z[, y], x), of as many cells across the gap as the last number.

    Raises
    ------
    ArithmeticError : it is not steady after `longest` units of time
    """
    state, modes = _at_rest(cells), _modes(cells, 1.0 / cells[-1])
    while state.time < longest:
        before = [u.copy() for u in state.velocity]
        begun = state.time
        for _ in range(50):
            _step(state, rayleigh, _stable(state), modes)
        change = max(float(np.abs(a - b).max()) for a, b in zip(state.velocity, before, strict=True))
        fastest = max(float(np.abs(u).max()) for u in state.velocity)
        if change < STEADY * fastest * (state.time - begun):
            return state
    raise ArithmeticError(f"the flow is not steady after {longest:g} units of time: is the Rayleigh number too large?")


def start(seconds: tuple[float, ...], finer: int = FINER) -> list[Floats]:
    """Velocity in mm/s at the nodes of the data set, so many seconds after the air at rest was let go; in rising order."""
    cells = tuple((n - 1) * finer for n in NODES)
    state, modes = _at_rest(cells), _modes(cells, 1.0 / cells[-1])
    found = []
    for wanted in seconds:
        while (left := wanted * CONDUCTIVITY / GAP**2 - state.time) > 1e-12:
            _step(state, RAYLEIGH, min(left, _stable(state)), modes)
        found.append(at_nodes(state, finer)["velocity"] * CONDUCTIVITY / GAP)
    return found


def _at_rest(cells: tuple[int, ...]) -> State:
    faces = [tuple(n + (a == b) for b, n in enumerate(cells)) for a in range(len(cells))]
    linear = np.broadcast_to(0.5 - (np.arange(cells[-1]) + 0.5) / cells[-1], cells).copy()
    return State(1.0 / cells[-1], [np.zeros(shape) for shape in faces], linear, np.zeros(cells))


def _stable(state: State) -> float:
    """The longest step that the explicit scheme bears."""
    fastest = max(float(np.abs(u).max()) for u in state.velocity) + 1e-12
    return min(0.9 * state.h**2 / (2 * len(state.velocity)), 1.5 / fastest**2, 0.5 * state.h / fastest)


def _modes(cells: tuple[int, ...], h: float) -> Floats:
    """Eigenvalues of the Laplacian of cells with walls that pass nothing; 1 for the constant."""
    total = np.zeros(cells)
    for axis, n in enumerate(cells):
        shape = [1] * len(cells)
        shape[axis] = n
        total = total + (2 * (np.cos(np.pi * np.arange(n) / n) - 1) / h**2).reshape(shape)
    total.flat[0] = 1.0
    return total


def _step(state: State, rayleigh: float, dt: float, modes: Floats) -> None:
    """One explicit step, and the projection on what neither gathers nor thins."""
    h, t = state.h, state.temperature
    trial = []
    for a, u in enumerate(state.velocity):
        inside = _inner(u, a)
        change = PRANDTL * _laplacian(u, a, h) - _advection(state.velocity, a, h)
        if a == 0:
            change += rayleigh * PRANDTL * _middle(t, 0)
        trial.append(_walled(inside + dt * change, a))
    heat = _diffused(t, h) - sum(
        np.diff(_walled(_inner(u, a) * _middle(t, a), a), axis=a) / h for a, u in enumerate(state.velocity)
    )
    divergence = sum(np.diff(u, axis=a) / h for a, u in enumerate(trial))
    spectrum = dctn(divergence / dt, type=2, norm="ortho") / modes
    spectrum.flat[0] = 0.0
    state.pressure = idctn(spectrum, type=2, norm="ortho")
    for a, u in enumerate(trial):
        inside = _inner(u, a)
        inside -= dt * np.diff(state.pressure, axis=a) / h
    state.velocity, state.temperature = trial, t + dt * heat
    state.time += dt


def _cut(rank: int, axis: int, part: slice) -> tuple[slice, ...]:
    return tuple(part if b == axis else slice(None) for b in range(rank))


def _inner(x: Floats, axis: int) -> Floats:
    """Without the first and the last along an axis; a view."""
    return x[_cut(x.ndim, axis, slice(1, -1))]


def _middle(x: Floats, axis: int) -> Floats:
    """Means of neighbours along an axis."""
    low, high = (x[_cut(x.ndim, axis, part)] for part in (slice(None, -1), slice(1, None)))
    return np.asarray(0.5 * (low + high))


def _walled(x: Floats, axis: int) -> Floats:
    """With a wall, where nothing passes, at both ends of an axis."""
    return np.pad(x, [(int(b == axis),) * 2 for b in range(x.ndim)])


def _laplacian(u: Floats, a: int, h: float) -> Floats:
    """Of the velocity across axis `a`, on the inner faces; beside a wall the velocity turns its sign."""
    total = np.diff(u, 2, axis=a)
    inside = _inner(u, a)
    for b in range(u.ndim):
        if b != a:
            first, last = (inside[_cut(u.ndim, b, part)] for part in (slice(0, 1), slice(-1, None)))
            total = total + np.diff(np.concatenate([-first, inside, -last], axis=b), 2, axis=b)
    return np.asarray(total / h**2)


def _advection(velocity: list[Floats], a: int, h: float) -> Floats:
    """Divergence of the momentum carried along, on the inner faces across axis `a`."""
    u = velocity[a]
    total = np.diff(_middle(u, a) ** 2, axis=a)
    for b, across in enumerate(velocity):
        if b != a:
            flux = _inner(_middle(across, a), b) * _middle(_inner(u, a), b)
            total = total + np.diff(_walled(flux, b), axis=b)
    return np.asarray(total / h)


def _diffused(t: Floats, h: float) -> Floats:
    """Of the temperature, in cells: 1/2 at the warm sheet, -1/2 at the cold one, no heat through other walls."""
    total = np.zeros_like(t)
    for b in range(t.ndim):
        first, last = (t[_cut(t.ndim, b, part)] for part in (slice(0, 1), slice(-1, None)))
        ends = (1.0 - first, -1.0 - last) if b == t.ndim - 1 else (first, last)
        total += np.diff(np.concatenate([ends[0], t, ends[1]], axis=b), 2, axis=b)
    return total / h**2


def nusselt(state: State) -> float:
    """The mean heat that crosses the gap, as a multiple of what conduction alone would carry."""
    t, x = state.temperature, state.temperature.ndim - 1
    first, last = (t[_cut(t.ndim, x, part)] for part in (slice(0, 1), slice(-1, None)))
    slope = np.diff(np.concatenate([1.0 - first, t, -1.0 - last], axis=x), axis=x) / state.h
    carried = _walled(_inner(state.velocity[x], x) * _middle(t, x), x)
    means = (carried - slope).mean(axis=tuple(range(x)))
    return float((means[1:-1].sum() + 0.5 * (means[0] + means[-1])) * state.h)


def benchmark(cells: int, rayleigh: float) -> tuple[float, float, float]:
    """Largest u on the vertical mid-line, largest v on the horizontal one, and Nu of de Vahl Davis's square cavity.

    Parameters
    ----------
    cells : along each side; an even number, so that faces lie on the mid-lines
    """
    if cells % 2:
        raise ValueError(f"{cells} cells have no face on the middle: give an even number")
    state = solve((cells, cells), rayleigh)
    v, u = state.velocity
    return _top(np.abs(u[:, cells // 2])), _top(np.abs(v[cells // 2])), nusselt(state)


def _top(values: Floats) -> float:
    """The top of the parabola through the largest of some values and its neighbours."""
    i = int(np.clip(np.argmax(values), 1, len(values) - 2))
    a, b, c = (float(v) for v in values[i - 1 : i + 2])
    return b - (a - c) ** 2 / (8 * (a - 2 * b + c))


def at_nodes(state: State, every: int) -> dict[str, Floats]:
    """Velocity (..., 3 in x, y, z), temperature and pressure at every so-many-th corner of the cells, without units."""
    rank = state.temperature.ndim
    found = []
    for a, u in enumerate(state.velocity):
        for b in range(rank):
            if b != a:
                u = _walled(_middle(u, b), b)  # at a wall nothing moves
        found.append(u)
    t, p = state.temperature, state.pressure
    for b in range(rank):
        if b == rank - 1:
            inside = _middle(t, b)
            t = np.pad(inside, [(int(c == b),) * 2 for c in range(rank)], constant_values=((0.5, -0.5),))
        else:
            t = _middle(np.pad(t, [(int(c == b),) * 2 for c in range(rank)], mode="edge"), b)
        p = _middle(np.pad(p, [(int(c == b),) * 2 for c in range(rank)], mode="reflect", reflect_type="odd"), b)
    cut = (slice(None, None, every),) * rank
    return {"velocity": np.stack(found[::-1], axis=-1)[cut], "temperature": t[cut], "pressure": p[cut]}


def glazing(finer: int = FINER) -> dict[str, Floats]:
    """Velocity in mm/s, temperature in degrees Celsius and pressure in mPa at the nodes of the data set."""
    found = at_nodes(solve(tuple((n - 1) * finer for n in NODES)), finer)
    speed = CONDUCTIVITY / GAP
    return {
        "velocity": found["velocity"] * speed,
        "temperature": (WARM + COLD) / 2 + (WARM - COLD) * found["temperature"],
        "pressure": (found["pressure"] - found["pressure"].mean()) * DENSITY * speed**2 * 1e-3,
    }


def write(path: Path, fields: dict[str, Floats]) -> None:
    """Store the fields as float32 in a VTK image."""
    import pyvista

    spacing = GAP / (NODES[2] - 1)
    data: Any = pyvista.ImageData(dimensions=NODES[::-1], spacing=(spacing,) * 3)
    for name, values in fields.items():
        data.point_data[name] = values.astype(np.float32).reshape(data.n_points, -1).squeeze()
    data.save(path, binary=True)


def write_start(folder: Path) -> None:
    """The velocity at each of some seconds from the start, as float32, with time and units."""
    from modules.api import EXACT, Frame, Missing, Samples
    from modules.data.exchange import save

    known = EXACT.miss(Missing("Discretisation", "of the solver, about 0.3 mm/s in the steady flow"))
    frame, spacing = Frame(units=("mm",) * 3), (GAP / (NODES[2] - 1),) * 3
    for i, (time, velocity) in enumerate(zip(SECONDS, start(SECONDS), strict=True)):
        stored = velocity.astype(np.float32)
        samples = Samples.from_array(stored, spacing=spacing, unit="mm/s", name="velocity", frame=frame, accuracy=known)
        save(replace(samples, time=time), folder / f"glazing-start-{i}.vti")


def main() -> None:
    """Print the benchmark and how much a finer lattice changes the flow, and write the file."""
    data = Path(__file__).resolve().parents[2] / "networks" / "data"
    if sys.argv[1:2] == ["start"]:
        write_start(data)
        return
    for rayleigh in (1e3, 1e4, 1e5):
        print(f"{rayleigh:g}", *(f"{v:.3f}" for v in benchmark(40, rayleigh)), flush=True)
    coarse, fine = glazing(FINER // 2), glazing(FINER)
    for name, values in fine.items():
        left = np.abs(values - coarse[name]).max() / 3
        print(name, f"{values.min():.4g} to {values.max():.4g}, discretisation about {left:.2g}", flush=True)
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else data / "double-glazing.vti", fine)


if __name__ == "__main__":
    main()

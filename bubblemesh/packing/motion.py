"""Equation of motion m x'' + c x' = F(x), equation (2.2) of the paper: explicit Runge-Kutta steps, and one cheaper."""

from collections.abc import Callable
from typing import Annotated, ClassVar, Protocol

import numpy as np
from annotated_types import Gt, Le
from typing_extensions import Doc

from bubblemesh.arrays import Floats
from bubblemesh.records import record

MOST_DAMPING = 1.5  # of c * dt

Force = Callable[[Floats], Floats]  # forces (n, 2) at positions (n, 2), without those that the boundary takes up
TimeStep = Annotated[float, Gt(0), Le(1), Doc("time step")]


class Motion(Protocol):
    """A step of the motion of bubbles of unit mass."""

    @property
    def evaluations(self) -> int:
        """Number of force evaluations of a step."""

    def __call__(self, x: Floats, v: Floats, c: Floats | float, force: Force) -> tuple[Floats, Floats]:
        """Positions and velocities (n, 2) after a step; ``c`` is the viscosity, a number or (n, 1)."""


@record
class RungeKutta:
    """Explicit Runge-Kutta step for unit mass; a subclass gives the tableau.

    An explicit step is unstable where c * dt exceeds 2: a larger viscosity is cut down to what the step can bear.
    """

    dt: TimeStep

    stages: ClassVar[tuple[tuple[float, ...], ...]]
    weights: ClassVar[tuple[float, ...]]

    @property
    def evaluations(self) -> int:
        return len(self.weights)

    def __call__(self, x: Floats, v: Floats, c: Floats | float, force: Force) -> tuple[Floats, Floats]:
        c = np.minimum(c, MOST_DAMPING / self.dt)
        velocities: list[Floats] = []
        accelerations: list[Floats] = []
        for row in self.stages:
            xs, vs = x, v
            for a, velocity, acceleration in zip(row, velocities, accelerations, strict=True):
                if a:
                    xs, vs = xs + a * self.dt * velocity, vs + a * self.dt * acceleration
            velocities.append(vs)
            accelerations.append(force(xs) - c * vs)
        for b, velocity, acceleration in zip(self.weights, velocities, accelerations, strict=True):
            x, v = x + b * self.dt * velocity, v + b * self.dt * acceleration
        return x, v


@record
class SecondOrderEuler(RungeKutta):
    """Predictor-corrector Euler step (Heun's method), of second order."""

    dt: TimeStep = 0.2

    stages: ClassVar[tuple[tuple[float, ...], ...]] = ((), (1.0,))
    weights: ClassVar[tuple[float, ...]] = (0.5, 0.5)


@record
class ClassicalRungeKutta(RungeKutta):
    """Runge-Kutta step of fourth order, the motion of the traditional method."""

    dt: TimeStep = 0.2

    stages: ClassVar[tuple[tuple[float, ...], ...]] = ((), (0.5,), (0.0, 0.5), (0.0, 0.0, 1.0))
    weights: ClassVar[tuple[float, ...]] = (1 / 6, 1 / 3, 1 / 3, 1 / 6)


@record
class SemiImplicitEuler:
    """Symplectic Euler step with implicit damping: of first order, one evaluation of the force, stable for any c.

    It is for motion whose end matters and not its course.
    """

    dt: TimeStep = 0.5

    evaluations: ClassVar[int] = 1

    def __call__(self, x: Floats, v: Floats, c: Floats | float, force: Force) -> tuple[Floats, Floats]:
        v = (v + self.dt * force(x)) / (1 + c * self.dt)
        return x + self.dt * v, v

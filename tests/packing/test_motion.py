import numpy as np
import pytest

from bubblemesh.packing.motion import ClassicalRungeKutta, SecondOrderEuler, SemiImplicitEuler

STEPS = np.array([20, 40, 80, 160])
END = 4.0
DAMPING = np.array([[0.3], [1.4], [2.0]])  # two oscillating, one critical


def exact(c, t):
    """x'' + c x' = -x, x(0) = 1, x'(0) = 0."""
    rate = np.sqrt(complex(c * c / 4 - 1)) or 1e-9
    x = np.exp(-c * t / 2) * (np.cosh(rate * t) + c / 2 * np.sinh(rate * t) / rate)
    v = -np.exp(-c * t / 2) * np.sinh(rate * t) / rate
    return x.real, v.real


def final_error(scheme, steps):
    x, v = np.ones((3, 2)), np.zeros((3, 2))
    step = scheme(dt=END / steps)
    for _ in range(steps):
        x, v = step(x, v, DAMPING, lambda at: -at)
    truth = np.array([exact(float(c), END) for c in DAMPING[:, 0]])
    return max(np.abs(x - truth[:, :1]).max(), np.abs(v - truth[:, 1:]).max())


@pytest.mark.parametrize(
    ("scheme", "order", "least"),
    [(SecondOrderEuler, 2, 1e-3), (ClassicalRungeKutta, 4, 1e-3), (SemiImplicitEuler, 1, 1e-2)],
)
def test_observed_order_for_the_damped_oscillator(scheme, order, least):
    errors = [final_error(scheme, int(steps)) for steps in STEPS]
    slope = np.polyfit(np.log(1 / STEPS), np.log(errors), 1)[0]
    assert slope == pytest.approx(order, abs=0.15)
    assert errors[-1] < least


@pytest.mark.parametrize(
    ("scheme", "evaluations"), [(SecondOrderEuler, 2), (ClassicalRungeKutta, 4), (SemiImplicitEuler, 1)]
)
def test_force_is_evaluated_as_often_as_said(scheme, evaluations):
    calls = []
    scheme(dt=0.1)(np.zeros((1, 2)), np.zeros((1, 2)), 1.0, lambda x: calls.append(1) or x)
    assert len(calls) == evaluations == scheme(dt=0.1).evaluations


def test_second_order_euler_is_the_predictor_corrector_of_the_paper():
    x, v, c, dt = np.array([[1.0, 2.0]]), np.array([[0.5, -1.0]]), 1.3, 0.2

    def force(at):
        return -(at**3)

    acceleration = force(x) - c * v
    predicted_x, predicted_v = x + dt * v, v + dt * acceleration
    corrected = force(predicted_x) - c * predicted_v
    found_x, found_v = SecondOrderEuler(dt=dt)(x, v, c, force)
    np.testing.assert_allclose(found_x, x + dt / 2 * (v + predicted_v), rtol=1e-15)
    np.testing.assert_allclose(found_v, v + dt / 2 * (acceleration + corrected), rtol=1e-15)


@pytest.mark.parametrize("c", [0.1, 2.0, 50.0, 1e9])
@pytest.mark.parametrize("dt", [0.1, 0.5, 1.0])
def test_implicit_damping_is_stable_for_any_viscosity(dt, c):
    x, v, farthest = np.ones((1, 2)), np.full((1, 2), 3.0), []
    step = SemiImplicitEuler(dt=dt)
    for _ in range(2000):
        x, v = step(x, v, c, lambda at: -at)
        farthest.append(np.abs(x).max())
    assert max(farthest) < 10
    assert np.abs(v).max() < 1e-3


def test_semi_implicit_step_damps_the_new_velocity_and_moves_by_it():
    x, v, c, dt = np.array([[1.0, 2.0]]), np.array([[0.5, -1.0]]), 1.3, 0.2
    found_x, found_v = SemiImplicitEuler(dt=dt)(x, v, c, lambda at: -(at**3))
    np.testing.assert_allclose((found_v - v) / dt, -(x**3) - c * found_v, rtol=1e-12)
    np.testing.assert_allclose(found_x, x + dt * found_v, rtol=1e-15)


@pytest.mark.parametrize("scheme", [SecondOrderEuler, ClassicalRungeKutta, SemiImplicitEuler])
def test_arguments_stay_as_they_are(scheme):
    x, v = np.ones((2, 2)), np.ones((2, 2))
    scheme(dt=0.1)(x, v, 1.0, lambda at: -at)
    assert (x == 1).all()
    assert (v == 1).all()


@pytest.mark.parametrize("scheme", [SecondOrderEuler, SemiImplicitEuler])
def test_bubbles_with_other_viscosities_move_by_themselves(scheme):
    x, v = np.ones((2, 2)), np.ones((2, 2))
    both = scheme()(x, v, np.array([[1.0], [3.0]]), lambda at: -at)
    for row, c in enumerate((1.0, 3.0)):
        alone = scheme()(x, v, c, lambda at: -at)
        for found, expected in zip(both, alone, strict=True):
            np.testing.assert_array_equal(found[row], expected[row])

"""Cases of random walls with random boundary layers."""

import numpy as np

ROOMS = [(1, 1), (3, 1), (1, 3), (3, 3)]  # middles of the places for walls, in a box of 4
LETTERS = (
    [(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (2.5, 2), (2.5, 3), (1, 3), (1, 4), (3, 4), (3, 5), (0, 5)],  # E
    [(0, 5), (2, 0), (3, 0), (5, 5), (4, 5), (2.5, 1), (1, 5)],  # V
    [(0, 0), (1, 0), (1.5, 1.5), (3, 1.5), (3.5, 0), (4.5, 0), (2.7, 5), (1.8, 5)],  # A
    [(0, 0), (1, 0), (1, 3), (3, 0), (4, 0), (4, 5), (3, 5), (3, 2), (1, 5), (0, 5)],  # N
)


def on_circle(radius, angle):
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def blob(random):
    count = random.integers(5, 14)
    return on_circle(0.6 * (1 + 0.3 * random.uniform(-1, 1, count)), np.linspace(0, 2 * np.pi, count, endpoint=False))


def gear(random):
    teeth, height = random.integers(5, 14), random.uniform(0.1, 0.35)
    angle = 2 * np.pi * (np.arange(teeth)[:, None] + np.array([0, 0.25, 0.5, 0.75])) / teeth
    return on_circle(0.65 * (1 + height * np.tile([0, 1, 1, 0], teeth)), angle.ravel())


def comb(random):
    teeth = random.integers(3, 8)
    width, found = 1.4 / (2 * teeth - 1), []
    for x in -0.7 + 2 * width * np.arange(teeth):
        top = random.uniform(0.2, 0.7)
        found += [(x, 0), (x, top), (x + width, top), (x + width, 0)]
    return np.array([*found, (0.7, -0.2), (-0.7, -0.2)])


def letter(random):
    points, turn = np.array(LETTERS[random.integers(len(LETTERS))], float), random.uniform(0, 2 * np.pi)
    points = 1.2 * (points - points.mean(axis=0)) / np.ptp(points, axis=0).max()
    return points @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])


def coast(random):
    count = random.integers(60, 400)
    angle, radius = np.linspace(0, 2 * np.pi, count, endpoint=False), np.ones(count)
    for wave in range(1, 30):
        radius += random.normal() * 0.25 / wave**1.3 * np.cos(wave * angle + random.uniform(0, 7))
    return on_circle(0.75 * np.clip(radius, 0.3, 1.8) / 1.6, angle)


SHAPES = (blob, gear, comb, letter, coast)


def walled(seed):
    """Case of one to three random walls in a box, all with layers of their own, and the box too sometimes."""
    random = np.random.default_rng(seed)
    spacing = random.uniform(0.05, 0.2)
    holes, layers = [], []
    for number, room in enumerate(random.permutation(ROOMS)[: random.integers(1, 4)]):
        shape = SHAPES[random.integers(len(SHAPES))]
        curved = {"smooth": True, "corners": 170} if shape is blob else {}
        holes.append({"polygon": (room + shape(random)).tolist(), "label": f"wall-{number}", **curved})
        layers.append({"on": f"wall-{number}", **_heights(random, spacing)})
    if random.random() < 0.4:
        layers.append(
            {"on": "box", "first": spacing * 10 ** random.uniform(-3, -0.7), "count": int(random.integers(2, 12))}
        )
    domain = {"outer": {"rectangle": [0, 0, 4, 4], "label": "box"}, "holes": holes}
    return {"domain": domain, "spacing": spacing, "layers": layers, "packing": {"effort": "fast"}}


def _heights(random, spacing):
    first, growth = spacing * 10 ** random.uniform(-3.5, -0.7), random.uniform(1.05, 1.6)
    keys = {"first": first, "growth": growth, "corners": "plain" if random.random() < 0.3 else "fans"}
    kind = random.integers(3)
    if kind == 0:
        return {**keys, "count": int(random.integers(1, 25))}
    return {**keys, "thickness": first * random.uniform(1.5, 60)} if kind == 1 else {**keys, "until": "isotropic"}

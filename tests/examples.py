"""The four examples of the paper and the dense variant of the third, as case files of the accelerated method."""

EXAMPLES = {
    "1": """
domain: {outer: {rectangle: [-1, -2, 1, 2]}}
spacing: 0.1
method: accelerated
packing: {w2: 1.0}
""",
    "2": """
domain:
  outer: {rectangle: [-1, -1, 1, 1]}
  holes: [{circle: {center: [0, 0], radius: 0.4}}]
spacing: "sqrt(x**2 + y**2)/8"
method: accelerated
packing: {w2: 0.64}
""",
    "3": """
domain: {outer: {rectangle: [-3, -3, 3, 3]}}
spacing: "0.2*abs(sqrt(x**2 + y**2) - 2) + 0.15"
method: accelerated
packing: {w2: 0.6}
""",
    "4": """
domain:
  outer:
    path:
      - [0.1, 0]
      - {to: [1, 0], label: base}
      - {arc: {to: [-1, 0], center: [0, 0], turn: left}, label: rim}
      - {to: [-0.9, 0], label: base}
      - {arc: {to: [0.1, 0], center: [-0.4, 0], turn: right}, label: bore}
spacing: "min(0.25 - 0.15*(hypot(x, y) - 1), 0.05 + 0.08*(hypot(x + 0.4, y) - 0.5),
  (hypot(x + 0.4, y) - 0.5 - (hypot(x, y) - 1))/2)"
method: accelerated
packing: {w2: 0.75}
""",
    "dense": """
domain: {outer: {rectangle: [-3, -3, 3, 3]}}
spacing: "0.35*abs(sqrt(x**2 + y**2) - 2) + 0.05"
method: accelerated
packing: {w2: 0.6}
""",
}

# The same domains and spacings, without any word on how to mesh them.
BARE = {
    name: "".join(line for line in text.splitlines(keepends=True) if not line.startswith(("method:", "packing:")))
    for name, text in EXAMPLES.items()
}

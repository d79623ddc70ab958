"""Cases as data for the tests."""

SQUARE = """\
domain:
  outer:
    polygon: [[0, 0], [1, 0], [1, 1], [0, 1]]
    labels: [bottom, on, no, 4]
  holes:
    - {circle: {center: [0.5, 0.5], radius: 0.2}, label: hole}
spacing: 0.1
"""

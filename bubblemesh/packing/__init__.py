"""Bubble packing: methods as rows of schemes, `multilevel` and the published ones, and the rounds that run them.

"The paper" is N. Qi, Y. Nie, W. Zhang, "Acceleration strategies based on an improved bubble packing method",
Communications in Computational Physics 16 (2014) 115-135, identified by its abstract.

The words of this room:

bubble
    A circle, or in a metric an ellipse, with a node of the mesh at its centre.
net
    Bubbles with the constrained Delaunay triangulation that connects them.
scheme
    How one task of a packing is done, such as placement or annealing, with its parameters.
method
    One scheme for each task: a row of the table, for circles or for ellipses.
shell
    The bubbles on the boundary, on lines and at points, which come first.
level
    One of several packings of increasing fineness; each starts from the one before.
rank
    Position of a level: how many are coarser, and how many finer. In `neighbours`, an order of preference.
stage
    The rounds on a level until the termination says stop; there is a second stage on a level with annealing.
round
    One pass of the main loop: bubbles move, are connected, and their number is controlled.
mending
    Trials at the end that give the worst triangles other surroundings.
"""

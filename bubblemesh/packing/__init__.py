"""Bubble packing: methods as rows of schemes, `multilevel` and the published ones, and the rounds that run them.

What is said here of "the paper" is of N. Qi, Y. Nie, W. Zhang, "Acceleration strategies based on an improved bubble
packing method", Communications in Computational Physics 16 (2014) 115-135, identified by its abstract.
"""

"""Meshes made in parts: the domain is cut, its parts are packed side by side and joined, and seams packed again.

The words of this room::

    +-------------+ - +-------------+   wall
    |             : | :             |
    |    core     : | :    core     |   | cut, with a landing on the wall at either end
    |             : | :             |   : inner end of the band of each part
    |             : | :             |
    +-------------+ - +-------------+   wall
         part               part

part
    A piece of the domain between cuts, packed as a domain of its own.
cut
    A straight line between parts, with bubbles that stay while the parts are packed.
landing
    A bubble on a wall or a line at which a cut ends or crosses.
core
    The triangles of a packed part that do not change any more.
band
    The nodes of a part on its boundary and along its cuts, and the triangles along the cuts.
margin
    Everything that is kept of a packed part apart from its core: the band, and figures of the core.
patch
    A band with numbers of nodes in the whole division, so that patches can be joined to one net.
seam
    The surroundings of a cut, packed once more with the bubbles of the cut free.
junction
    The surroundings of an end of a cut, packed once more after the seams.
strip
    A part of the net along seams, or around junctions, that is packed once more as a domain of its own.
store
    Keeps packed parts, in memory or in files.
crew
    Calls functions for jobs: in this process, in worker processes, or on a cluster.
workshop
    A crew with its store and its listeners.
terms
    What the packing of all parts and strips has in common: spacing, method, limits.
"""

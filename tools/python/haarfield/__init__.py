"""Baked light, visibility fields and wavelet product integrals.

    import haarfield
    scene = haarfield.open("scenes/single_chair.toml")
    bake = scene.bake()
    print(bake["chair"].radiance)    # (N, 3), a numpy array
    bake.write_povray("out")

Units are metres and W/(m^2 sr); colours are linear RGB; the frame is right-handed with +y up. Angles are degrees.
Long calls let other threads run, accept a progress function and end on Ctrl-C.
"""

from haarfield._haarfield import *  # noqa: F401,F403
from haarfield._haarfield import __version__  # noqa: F401
from haarfield._signatures import add_signatures as _add_signatures

_add_signatures(globals())
del _add_signatures

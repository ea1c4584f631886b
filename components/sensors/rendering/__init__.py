"""Pictures of people among walls: a z-buffer of tapered bodies and triangles, shaded once per pixel."""

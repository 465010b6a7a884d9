"""The camera of halfpixel's fitted views (src/scene/camera.rs), so that peers draw the same picture."""

import math

DIRECTIONS = {"iso": (1.0, -1.0, 0.8), "front": (0.0, -1.0, 0.0), "back": (0.0, 1.0, 0.0), "left": (-1.0, 0.0, 0.0),
              "right": (1.0, 0.0, 0.0), "top": (0.0, 0.0, 1.0), "bottom": (0.0, 0.0, -1.0)}
UPS = {"top": (0.0, 1.0, 0.0), "bottom": (0.0, -1.0, 0.0)}
FOV_DEGREES = 45.0


class Camera:
    """Perspective, 45 degrees of vertical field of view; the bounding sphere of the box fits with 5 % to spare."""

    def __init__(self, bounds, size=(1920, 1080), view="iso", zoom=1.0):
        low, high = bounds
        self.target = tuple((a + b) / 2 for a, b in zip(low, high))
        self.radius = math.dist(low, high) / 2
        half_fov = math.radians(FOV_DEGREES) / 2
        focal = size[1] / 2 / math.tan(half_fov)
        half_smaller = math.atan(min(size) / 2 / focal)
        self.distance = 1.05 * self.radius / math.sin(half_smaller)
        direction = DIRECTIONS[view]
        length = math.hypot(*direction)
        self.eye = tuple(t + d / length * self.distance for t, d in zip(self.target, direction))
        self.up = UPS.get(view, (0.0, 0.0, 1.0))
        self.focal = focal * zoom
        self.fov_degrees = 2 * math.degrees(math.atan(size[1] / 2 / self.focal))

    def half_pixel(self):
        """Half a pixel in model units, at the depth of the model's centre.

        What is nearer to the eye than the centre has smaller pixels, so a mesh with this deflection breaks the half
        pixel there: it is the peer's favourable case.
        """
        return 0.5 * self.distance / self.focal


def parse_bounds(text):
    """`x0,y0,z0,x1,y1,z1`, as an argument."""
    values = [float(v) for v in text.split(",")]
    if len(values) != 6:
        raise ValueError("bounds are six numbers: x0,y0,z0,x1,y1,z1")
    return values[:3], values[3:]

"""Converts Blender's lights to lamps of haarfield's scenes, with Cycles' units and shapes."""

import math

import bpy
import numpy

from .frame import TO_HAARFIELD
from .shaders import output_of, source_of, value_of

# Light falls off as 2 / (1 + (d / FADE)^2), which is 2 FADE^2 / d^2 to 1e-4 at ten centimetres. [m]
FADE = 1e-3
# The largest colour that scenes accept, with a margin.
BRIGHTEST = 5e8
# Number of places along an edge of a lamp's area. Powers of two have equal weights.
SMALL, LARGE = 8, 16
# Since Blender 4, Cycles has other units for area lights and suns, and the intensity of spots has no factor of the cosine.
IS_NEW = bpy.app.version >= (4, 0)
# A sun is a lamp at this multiple of the scene's extent: its directions are off by at most 1e-4 rad.
FAR, FARTHEST = 1e4, 5e5


def radiant_colour(light, where, warnings):
    """Returns a light's power times its colour, with the constants of its nodes. [W, or W/m^2 for a sun]"""
    colour = light.energy * numpy.array(light.color[:3], float)
    if light.use_nodes:
        output = output_of(light.node_tree, "OUTPUT_LIGHT")
        node = source_of(output.inputs["Surface"]) if output else None
        if node is None:
            warnings.append(f"{where}: its nodes have no surface, so it emits no light")
            return numpy.zeros(3)
        if node.type == "EMISSION":
            strength = value_of(node, "Strength", where, warnings)
            colour = colour * strength * value_of(node, "Color", where, warnings)
        else:
            warnings.append(f"{where}: its surface is {node.bl_label}; expected Emission. The colour of the light is used")
    if (colour < 0).any():
        warnings.append(f"{where}: negative light is ignored")
    return numpy.maximum(colour, 0)


def inverse_square(intensity):
    """Returns the keys of a lamp with this intensity on its axis. [W/sr]"""
    reflected = intensity / math.pi
    distance = max(FADE, math.sqrt(reflected.max() / (2 * BRIGHTEST)))
    return {"colour": (reflected / (2 * distance**2)).tolist(), "fade_distance": distance, "fade_power": 2}


def area_table(across, along, count, circular, orient=False):
    """Returns an area lamp whose places are the centres of equal cells."""
    inner = (count - 1) / count
    return {
        "across": (inner * across).tolist(),
        "along": (inner * along).tolist(),
        "samples": [count, count],
        "circular": circular,
        "orient": orient,
        "illumination": True,
    }


def ball_keys(radius):
    """Returns the keys of an area light that faces every point as a disc."""
    if radius < 1e-5:
        return {}
    edges = 2 * radius * numpy.eye(3)
    return {"area": area_table(edges[0], edges[2], SMALL, circular=True, orient=True)}


def spot_keys(size, blend):
    """Returns the keys of Cycles' cone, which equals POV-Ray's: a smooth step of the cosine, times the cosine before
    Blender 4.
    """
    edge = math.cos(size / 2)
    begin = math.acos(min(1.0, edge + (1 - edge) * blend))
    falloff = math.degrees(size / 2)
    return {"radius": min(math.degrees(begin), falloff), "falloff": falloff, "tightness": 0 if IS_NEW else 1}


def spread_keys(spread):
    """Returns the cone that best approximates an area light's spread.

    returns  its keys, the ratio of its intensity on the axis to that of a light of full spread, and the root mean
             square difference relative to the root mean square of Cycles' intensity.
    """
    half = spread / 2
    if half > math.pi / 2 - 1e-4:
        return {"radius": 90, "falloff": 90, "tightness": 1}, 1.0, 0.0
    half = max(half, math.radians(0.5))
    angle = (numpy.arange(256) + 0.5) / 256 * half
    weight = numpy.sin(angle)
    slope = 1 / math.tan(half)
    wanted = (numpy.cos(angle) - slope * numpy.sin(angle)) / (1 - half * slope)
    best = None
    for begin in numpy.linspace(0, half, 33)[:-1]:
        t = numpy.clip((numpy.cos(angle) - math.cos(half)) / (math.cos(begin) - math.cos(half)), 0, 1)
        edge = t * t * (3 - 2 * t)
        for tightness in (0, *numpy.geomspace(0.25, 100, 48)):
            shape = edge * numpy.cos(angle) ** tightness
            # Scales to the same flux.
            scale = (weight * wanted).sum() / (weight * shape).sum()
            error = (weight * (scale * shape - wanted) ** 2).sum()
            if best is None or error < best[0]:
                best = (error, begin, tightness, scale)
    error, begin, tightness, scale = best
    keys = {"radius": math.degrees(begin), "falloff": math.degrees(half), "tightness": float(tightness)}
    return keys, float(scale), math.sqrt(error / (weight * wanted**2).sum())


def area_light(light, matrix, colour, where, warnings):
    is_long = light.shape in ("RECTANGLE", "ELLIPSE")
    across = matrix[:3, 0] * light.size
    along = matrix[:3, 1] * (light.size_y if is_long else light.size)
    cone, axial, error = spread_keys(light.spread)
    if error > 0:
        warnings.append(
            f"{where}: its spread of {math.degrees(light.spread):.0f} degrees is approximated by a cone, with an error of "
            f"{100 * error:.0f} %"
        )
    lamp = {"kind": "spot", **cone, **inverse_square(axial * colour / (math.pi if IS_NEW else 4))}
    if min(numpy.linalg.norm(across), numpy.linalg.norm(along)) > 1e-6:
        is_round = light.shape in ("DISK", "ELLIPSE")
        lamp["area"] = area_table(TO_HAARFIELD @ across, TO_HAARFIELD @ along, LARGE, is_round)
    return lamp


def sun_light(light, towards, colour, extent):
    """Returns a distant round lamp with the irradiance of Cycles."""
    radius = math.tan(min(light.angle / 2, 1.4))
    if IS_NEW:
        # The strength is the irradiance of a surface that faces the sun: divided by the mean cosine of the disc.
        colour = colour * (math.sqrt(1 + radius**2) + 1) / 2
    distance = min(FAR * max(extent, 1.0), FARTHEST / max(1.0, radius))
    position = -distance * towards
    lamp = {"kind": "parallel", "colour": (colour / math.pi).tolist(), "position": position.tolist()}
    if radius > 1e-5:
        side = numpy.cross(towards, numpy.eye(3)[numpy.argmin(abs(towards))])
        side *= 2 * radius * distance / numpy.linalg.norm(side)
        lamp["kind"] = "point"  # its light is parallel across the scene
        lamp["area"] = area_table(side, numpy.cross(towards, side), SMALL, circular=True)
    else:
        lamp["target"] = (position + towards * distance).tolist()
    return lamp


def casts_shadows(light):
    return light.use_shadow and getattr(getattr(light, "cycles", None), "cast_shadow", True)


def report_losses(object, where, warnings):
    """Warns about properties that haarfield's lamps do not support."""
    light = object.data
    for name in ("diffuse_factor", "specular_factor"):
        if abs(getattr(light, name) - 1) > 1e-6:
            warnings.append(f"{where}: its {name.split('_')[0]} factor is ignored")
    for name in ("diffuse", "glossy"):
        if not getattr(object, f"visible_{name}"):
            warnings.append(f"{where}: it lights {name} surfaces too; its ray visibility is ignored")
    if not casts_shadows(light):
        warnings.append(f"{where}: casts no shadows, and no specular light, as in POV-Ray")


def lamp_of(object, matrix_world, name, extent, warnings):
    """Returns a light as a table of [[lights]]; None if it emits no light.

    extent  the largest distance of lit surfaces from the origin. [m]
    """
    light, where = object.data, f"Light '{name}'"
    if light.type == "AREA" and hasattr(light, "cycles") and light.cycles.is_portal:
        warnings.append(f"{where}: is a portal, which is ignored")
        return None
    colour = radiant_colour(light, where, warnings)
    if not colour.any():
        return None
    report_losses(object, where, warnings)
    matrix = numpy.array(matrix_world, float)
    position = TO_HAARFIELD @ matrix[:3, 3]
    depth = numpy.linalg.norm(matrix[:3, 2])
    towards = TO_HAARFIELD @ (-matrix[:3, 2] / depth if depth > 0 else numpy.array([0.0, 0.0, -1.0]))
    if light.type == "SUN":
        lamp = sun_light(light, towards, colour, extent)
    else:
        if light.type == "AREA":
            lamp = area_light(light, matrix, colour, where, warnings)
        else:
            lamp = {"kind": "point", **inverse_square(colour / (4 * math.pi)), **ball_keys(light.shadow_soft_size)}
            if light.type == "SPOT":
                lamp |= {"kind": "spot", **spot_keys(light.spot_size, light.spot_blend)}
        lamp["position"] = position.tolist()
        if lamp["kind"] == "spot":
            lamp["target"] = (position + towards).tolist()
    lamp["shadowless"] = not casts_shadows(light)
    return lamp

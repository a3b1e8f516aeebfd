"""Converts Blender's materials and worlds to those of haarfield."""

import numpy

# The middle of an equirectangular image is +x in Blender and +z in haarfield, whose world has +y up.
TURN_OF_IMAGES = 90.0


class Refusal(Exception):
    """An error message for the user about a scene that cannot be baked."""


def pixels_of(image, channels=3):
    """Returns an image's linear pixels, (height, width, channels), rows from the top."""
    width, height = image.size
    if width == 0 or height == 0:
        raise Refusal(f"Image '{image.name}' has no pixels; check that its file exists")
    flat = numpy.empty(width * height * image.channels, numpy.float32)
    image.pixels.foreach_get(flat)
    pixels = flat.reshape(height, width, image.channels)[::-1]
    if image.channels < 3:
        pixels = numpy.repeat(pixels[..., :1], 3, axis=2)
    pixels = pixels[..., :channels]
    # Float images are linear in memory; other images have the encoding of their files.
    if not image.is_float and image.colorspace_settings.name == "sRGB":
        pixels = decoded(pixels)
    return numpy.ascontiguousarray(pixels, numpy.float32)


def decoded(encoded):
    """Returns the linear values of sRGB values in [0, 1]."""
    return numpy.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def bytes_of(image):
    """Returns an image as sRGB bytes, (height, width, 3): lossless if its file has 8 bits."""
    linear = numpy.clip(pixels_of(image), 0, 1)
    encoded = numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return (encoded * 255 + 0.5).astype(numpy.uint8)


def source_of(socket):
    """Returns the node that a socket is linked to, through reroutes; None if there is none."""
    while socket.is_linked:
        link = socket.links[0]
        if link.from_node.type != "REROUTE":
            return link.from_node
        socket = link.from_node.inputs[0]
    return None


def output_of(tree, kind):
    for node in tree.nodes:
        if node.type == kind and node.is_active_output:
            return node
    return None


def value_of(node, name, where, warnings):
    socket = node.inputs[name]
    if source_of(socket) is not None:
        warnings.append(f"{where}: its {name} from {source_of(socket).bl_label} is ignored; the constant is used")
    value = socket.default_value
    return float(value) if isinstance(value, (int, float)) else [float(channel) for channel in value[:3]]


# Names of sockets of the Principled BSDF in Blender 4, where they differ from those of Blender 3.
NEW_NAMES = {
    "Specular": "Specular IOR Level",
    "Emission": "Emission Color",
    "Transmission": "Transmission Weight",
    "Subsurface": "Subsurface Weight",
    "Clearcoat": "Coat Weight",
    "Sheen": "Sheen Weight",
}


def principled_value(node, name, where, warnings):
    """Returns the value of a socket of a Principled BSDF.

    name  that of Blender 3.
    """
    return value_of(node, name if name in node.inputs else NEW_NAMES[name], where, warnings)


def dielectric_of(node, where, warnings):
    """Returns the reflectance at normal incidence of a Principled BSDF that is not metallic."""
    level = max(0.0, principled_value(node, "Specular", where, warnings))
    if "Specular" in node.inputs:
        return 0.08 * level
    ior = max(1.0, value_of(node, "IOR", where, warnings))
    return 2 * level * ((ior - 1) / (ior + 1)) ** 2


def image_node_of(socket, where, warnings):
    """Returns the image texture of a colour; None if the colour is constant."""
    node = source_of(socket)
    if node is None:
        return None
    if node.type == "TEX_IMAGE" and node.image is not None:
        if node.inputs["Vector"].is_linked and source_of(node.inputs["Vector"]).type not in ("UVMAP", "TEX_COORD"):
            warnings.append(f"{where}: the mapping of image '{node.image.name}' is ignored")
        return node
    warnings.append(f"{where}: colours from {node.bl_label} are ignored; expected a constant or an Image Texture")
    return None


def clamped(colour):
    return [min(max(channel, 0.0), 1.0) for channel in colour]


def shader_of(material, warnings):
    """Returns the node of a material's surface; None if its viewport colour is used instead."""
    if material is None or not material.use_nodes:
        return None
    output = output_of(material.node_tree, "OUTPUT_MATERIAL")
    node = source_of(output.inputs["Surface"]) if output else None
    if node is not None and node.type in ("BSDF_PRINCIPLED", "BSDF_DIFFUSE", "EMISSION"):
        return node
    found = node.bl_label if node else "missing"
    warnings.append(
        f"Material '{material.name}': its surface is {found}; expected Principled BSDF, Diffuse BSDF or Emission. "
        "Its viewport colour is used"
    )
    return None


def material_of(material, warnings):
    """Returns a material as a table of haarfield's scenes, and the image texture node of its colour."""
    if material is None:
        return {"diffuse": [0.8, 0.8, 0.8]}, None
    where = f"Material '{material.name}'"
    report_outputs(material, where, warnings)
    node = shader_of(material, warnings)
    if node is None:
        return {"diffuse": clamped(material.diffuse_color[:3])}, None
    if node.type == "EMISSION":
        strength = value_of(node, "Strength", where, warnings)
        colour = value_of(node, "Color", where, warnings)
        return {"diffuse": [0, 0, 0], "emission": [max(0.0, strength * channel) for channel in colour]}, None
    colour = node.inputs["Color" if node.type == "BSDF_DIFFUSE" else "Base Color"]
    image = image_node_of(colour, where, warnings)
    base = [1.0, 1.0, 1.0] if image else clamped(colour.default_value[:3])
    table = {"diffuse": base}
    if image:
        table["image"] = bytes_of(image.image)
    if node.type == "BSDF_DIFFUSE":
        return table, image
    metallic = min(max(value_of(node, "Metallic", where, warnings), 0.0), 1.0)
    roughness = min(max(value_of(node, "Roughness", where, warnings), 0.0), 1.0)
    dielectric = dielectric_of(node, where, warnings) * (1 - metallic)
    metal = pixels_of(image.image).mean(axis=(0, 1)).tolist() if image else base
    table["diffuse"] = [(1 - metallic) * channel for channel in base]
    table["specular"] = clamped([dielectric + metallic * channel for channel in metal])
    # A Phong lobe of the same width as GGX of this roughness.
    table["shininess"] = min(max((2 / max(roughness, 0.05) ** 4 - 2) / 4, 1.0), 1000.0)
    strength = value_of(node, "Emission Strength", where, warnings)
    emission = [max(0.0, strength * channel) for channel in principled_value(node, "Emission", where, warnings)]
    if any(emission):
        table["emission"] = emission
    for name in ("Transmission", "Subsurface", "Clearcoat", "Sheen"):
        if principled_value(node, name, where, []) > 0:
            warnings.append(f"{where}: {name} is ignored")
    if source_of(node.inputs["Normal"]) is not None:
        warnings.append(f"{where}: its normal map is ignored")
    if node.inputs["Alpha"].default_value < 1 or node.inputs["Alpha"].is_linked:
        warnings.append(f"{where}: Alpha is ignored")
    return table, image


def lat_long_of(pixels, rotation=None):
    """Resamples pixels of another shape or orientation to a lat-long image of twice its height in width, bilinearly.

    rotation  (3, 3), from a direction in Blender's world to the direction of the lookup.
    """
    height = min(2048, max(pixels.shape[0], pixels.shape[1] // 2))
    v, u = numpy.mgrid[0:height, 0 : 2 * height] + 0.5
    azimuth, latitude = numpy.pi * (1 - u / height), numpy.pi * (0.5 - v / height)
    if rotation is not None:
        direction = numpy.stack(
            [numpy.cos(azimuth) * numpy.cos(latitude), numpy.sin(azimuth) * numpy.cos(latitude), numpy.sin(latitude)], -1
        )
        direction = direction @ numpy.asarray(rotation).T
        azimuth = numpy.arctan2(direction[..., 1], direction[..., 0])
        latitude = numpy.arcsin(numpy.clip(direction[..., 2], -1, 1))
    x = (0.5 - azimuth / (2 * numpy.pi)) * pixels.shape[1] - 0.5
    y = numpy.clip((0.5 - latitude / numpy.pi) * pixels.shape[0] - 0.5, 0, pixels.shape[0] - 1)
    left, top = numpy.floor(x).astype(int), numpy.floor(y).astype(int)
    right, down = (x - left)[..., None], (y - top)[..., None]
    below = numpy.minimum(top + 1, pixels.shape[0] - 1)
    at = lambda row, column: pixels[row, column % pixels.shape[1]]
    upper = at(top, left) * (1 - right) + at(top, left + 1) * right
    lower = at(below, left) * (1 - right) + at(below, left + 1) * right
    return (upper * (1 - down) + lower * down).astype(numpy.float32)


def is_volume(material):
    """Tests whether a material has a volume and no surface."""
    output = output_of(material.node_tree, "OUTPUT_MATERIAL") if material and material.use_nodes else None
    return bool(output and source_of(output.inputs["Volume"]) and not source_of(output.inputs["Surface"]))


def report_outputs(material, where, warnings):
    """Warns about outputs of a material that are not baked."""
    output = output_of(material.node_tree, "OUTPUT_MATERIAL") if material.use_nodes else None
    for name in ("Volume", "Displacement"):
        if output and source_of(output.inputs[name]):
            warnings.append(f"{where}: its {name.lower()} is ignored")


def world_of(world, has_lights, warnings):
    """Returns a world as the environment of a scene of haarfield."""
    if world is None:
        if has_lights:
            return constant_light((0, 0, 0))
        raise Refusal("The scene has no world and no lights; expected either")
    if not world.use_nodes:
        return constant_light(world.color)
    output = output_of(world.node_tree, "OUTPUT_WORLD")
    if output and source_of(output.inputs["Volume"]):
        warnings.append(f"World '{world.name}': its volume is ignored")
    background = source_of(output.inputs["Surface"]) if output else None
    if background is None and has_lights:
        warnings.append(f"World '{world.name}': it has no surface shader and is black, as in Cycles")
        return constant_light((0, 0, 0))
    if background is None or background.type != "BACKGROUND":
        found = background.bl_label if background else "missing"
        raise Refusal(f"World '{world.name}': its surface is {found}; expected Background")
    where = f"World '{world.name}'"
    strength = max(0.0, value_of(background, "Strength", where, warnings))
    texture = source_of(background.inputs["Color"])
    if texture is None:
        return constant_light([strength * channel for channel in background.inputs["Color"].default_value[:3]])
    if texture.type != "TEX_ENVIRONMENT" or texture.image is None:
        raise Refusal(f"{where}: its colour is from {texture.bl_label}; expected an Environment Texture or a constant")
    if texture.projection != "EQUIRECTANGULAR":
        raise Refusal(f"{where}: the projection of '{texture.image.name}' is {texture.projection.lower()}; "
                      "expected equirectangular")
    pixels = strength * pixels_of(texture.image)
    turn = TURN_OF_IMAGES
    mapping = source_of(texture.inputs["Vector"])
    lookup = None
    if mapping is not None and mapping.type == "MAPPING":
        if any(abs(x) > 1e-6 for x in mapping.inputs["Location"].default_value) or any(
            abs(x - 1) > 1e-6 for x in mapping.inputs["Scale"].default_value
        ):
            raise Refusal(f"{where}: its mapping moves or scales the image; expected rotations only")
        euler = mapping.inputs["Rotation"].default_value
        matrix = euler.to_matrix()
        if mapping.vector_type == "TEXTURE":
            matrix = matrix.transposed()
        elif mapping.vector_type not in ("POINT", "VECTOR", "NORMAL"):
            raise Refusal(f"{where}: its mapping is of type {mapping.vector_type}; expected Texture, Point, Vector or Normal")
        if abs(euler.x) < 1e-6 and abs(euler.y) < 1e-6:
            sign = 1 if mapping.vector_type == "TEXTURE" else -1
            turn += sign * numpy.degrees(euler.z)
        else:
            lookup = matrix
    elif mapping is not None and mapping.type != "TEX_COORD":
        raise Refusal(f"{where}: its image is placed by {mapping.bl_label}; expected a Mapping")
    if lookup is not None or pixels.shape[1] != 2 * pixels.shape[0]:
        pixels = lat_long_of(pixels, lookup)
    turn = float((turn + 180) % 360 - 180)
    return {"image": pixels, "rotation": turn}


def constant_light(colour):
    pixels = numpy.empty((8, 16, 3), numpy.float32)
    pixels[:] = numpy.asarray(colour[:3])
    return {"image": pixels}

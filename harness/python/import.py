"""Reads a height map in a format of an instrument, by the library SurfaceTopography; writes Gwyddion Simple Field.

    python3 import.py FILE OUT SOURCE [CHANNEL]

OUT gets the field: lengths and heights in metres, the top row first, NaN where nothing was measured. Facts go to stdout as one
JSON object, with lengths in µm, or in the file's numbers if it states no unit; an object with the key `error` says why nothing was written, in words for users.
"""

import json
import re
import shlex
import sys
import warnings

import gwyfile
import numpy as np
from SurfaceTopography.IO import CannotDetectFileFormat, open_topography
from SurfaceTopography.Support.UnitConversion import get_unit_conversion_factor

# words for the direction of a scan: channels that differ in nothing else hold the same heights
DIRECTIONS = r"\b(forward|backward|trace|retrace|fwd|bwd|left|right)\b"
# heights by a sensor are better than heights by the voltage of the piezo that moves the tip
BY_SENSOR = ("zsensor", "height sensor", "heightsensor")
# a height that is rounded to a 32-bit float may be wrong by this share of peak to valley
ROUNDING = 1e-5


class Unitless:
    """A channel of a Gwyddion file whose values have no unit: SurfaceTopography leaves such channels out."""

    is_height_channel, is_uniform, unit, info = True, True, None, {}

    def __init__(self, index, name, field):
        self.index, self.name, self.field = index, name, field
        self.physical_sizes = field.xreal, field.yreal

    def topography(self):
        return self

    def heights(self):
        return self.field.data.T


class Refused(Exception):
    """A reason in words for users, and what they can do about it."""


def choose(channels, wanted):
    """The channel, and why it was chosen where there was a choice."""
    names = ", ".join(repr(channel.name) for channel in channels)
    if wanted is not None:
        found = [channel for channel in channels if channel.name == wanted]
        found = found or [channel for channel in channels if channel.name.lower() == wanted.lower()]
        if not found:
            raise Refused(f"has no channel '{wanted}'", f"one of {names}")
        if not has_heights(found[0]):
            raise Refused(f"the channel '{wanted}' holds no heights", heights_of(channels))
        return found[0], None
    heights = [channel for channel in channels if has_heights(channel)]
    if not heights:
        raise Refused(f"has no channel of heights, only {names}" if channels else "has no channel whose values have a unit of length",
                      "export heights from the instrument's program, with their units")
    if len(heights) == 1:
        return heights[0], None
    if len({re.sub(DIRECTIONS, "", channel.name.lower()) for channel in heights}) == 1:
        return heights[0], "the first of several scans of the same heights"
    by_sensor = [channel for channel in heights if channel.name.lower() in BY_SENSOR]
    if len(by_sensor) == 1:
        return by_sensor[0], "heights by the sensor"
    raise Refused("has several channels of heights", heights_of(channels))


def has_heights(channel):
    # readers give a pair of units, of lengths and of values, where the two differ
    one_unit = channel.unit is None or isinstance(channel.unit, str)
    return channel.is_height_channel and one_unit and not in_amperes(channel)


def in_amperes(channel):
    """Whether a Gwyddion file says so: its `A`, which SurfaceTopography takes for the ångström, is the ampere."""
    raw = (channel.info or {}).get("raw_metadata") or {}
    for key, value in raw.items() if isinstance(raw, dict) else ():
        if str(key).endswith("/data") and isinstance(value, dict) and "GwyDataField" in value:
            unit = value["GwyDataField"].get("si_unit_z", {}).get("GwySIUnit", {})
            return unit.get("unitstr") == "A"
    return False


def heights_of(channels):
    heights = [channel.name for channel in channels if has_heights(channel)]
    return "--channel " + " or ".join(shlex.quote(name) for name in heights) if heights else "it has no channel of heights"


def metres(unit):
    """Metres in a unit of a file; None if it is no unit of length."""
    try:
        return get_unit_conversion_factor(unit, "m") if unit else None
    except Exception:
        return None


def opened(path):
    """The name of the format, and the channels."""
    reader = open_topography(path)
    if reader.channels or reader.format() != "gwy":
        return reader.name(), reader.channels
    container = gwyfile.load(path)
    keys = [key for key in container if re.fullmatch(r"/\d+/data", key) and not unit_of_values(container[key])]
    return reader.name(), [Unitless(i, container.get(f"{key}/title", key), container[key]) for i, key in enumerate(keys)]


def unit_of_values(field):
    return (field.get("si_unit_z") or {}).get("unitstr", "")


def read(path, wanted):
    """Heights in metres, top row first, and the size in metres, or both in the file's numbers if it states no unit; facts."""
    name, channels = opened(path)
    channel, reason = choose(channels, wanted)
    topography = channel.topography()
    if not topography.is_uniform:
        raise Refused("is a profile with uneven steps, which a height map cannot hold", "resample it to even steps")
    unit = topography.unit or None
    scale = metres(unit) if unit else 1.0
    if scale is None:
        raise Refused(f"states the unit '{unit}', which is no length", "state it in the instrument's program")
    # SurfaceTopography counts [x, y] with y from the top, as Gwyddion draws it
    heights = np.ma.filled(np.ma.asarray(topography.heights(), dtype=float), np.nan).T * scale
    sizes = [size * scale for size in topography.physical_sizes]
    if heights.ndim == 1:
        heights = heights[np.newaxis, :]
        sizes.append(sizes[0] / heights.shape[1])
    if not np.isfinite(heights).any():
        raise Refused("has no measured height in this channel", "choose another channel")
    others = [{"name": c.name, "heights": has_heights(c)} for c in channels if c.index != channel.index]
    facts = {
        "format": name, "channel": channel.name, "reason": reason, "file_unit": unit, "others": others,
        "metadata": sorted(key for key in (topography.info or {}) if key != "unit"),
    }
    return heights, sizes, facts


def write(path, heights, sizes, unit, title, source):
    """A field as GSF; `unit` is m, or empty. Header lines end at a multiple of four bytes, filled with at least one NUL."""
    rows, columns = heights.shape
    one_line = lambda text: " ".join(str(text).split())
    header = (
        f"Gwyddion Simple Field 1.0\nXRes = {columns}\nYRes = {rows}\nXReal = {float(sizes[0])!r}\nYReal = {float(sizes[1])!r}\n"
        f"XYUnits = {unit}\nZUnits = {unit}\nTitle = {one_line(title)}\nImporter = diffraction import\nSource = {one_line(source)}\n"
    ).encode()
    with open(path, "wb") as file:
        file.write(header + b"\0" * (4 - len(header) % 4))
        file.write(heights.astype("<f4").tobytes())


def run(path, out, source, wanted=None):
    heights, sizes, facts = read(path, wanted)
    low, high = float(np.nanmin(heights)), float(np.nanmax(heights))
    offset = 0.0
    if max(abs(low), abs(high)) * 2.0**-24 > ROUNDING * (high - low):
        offset = (low + high) / 2
        heights = heights - offset
    write(out, heights, sizes, "m" if facts["file_unit"] else "", facts["channel"], source)
    factor = 1e6 if facts["file_unit"] else 1.0
    return facts | {
        "columns": heights.shape[1], "rows": heights.shape[0], "size": [size * factor for size in sizes],
        "peak_to_valley": (high - low) * factor, "offset": offset * factor,
        "voids": int(heights.size - np.isfinite(heights).sum()),
    }


def main(*words):
    # what is not a user's affair stays out of the messages
    warnings.simplefilter("ignore")
    try:
        answer = run(*words)
    except Refused as refused:
        answer = dict(zip(("error", "remedy"), refused.args))
    except CannotDetectFileFormat:
        answer = {"error": "is in no format that SurfaceTopography reads, or damaged", "remedy": "png, tiff, exr, npy, gsf, txt and csv need no import"}
    except MemoryError:
        answer = {"error": "does not fit into memory"}
    except Exception as error:  # whatever a reader raises on a file that is not what it seems
        text = " ".join(str(error).split()) or "no further reason"
        answer = {"error": f"cannot be read: {type(error).__name__}: {text[:500]}"}
    print(json.dumps(answer))


if __name__ == "__main__":
    main(*sys.argv[1:])

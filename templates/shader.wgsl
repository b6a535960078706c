// Diffraction colours of a height field, for one direction to the light and one to the viewer.
//
// Input: diffraction(wi, wr) takes unit vectors that point away from the surface, wi to the light and wr to the viewer,
// in the tangent frame: x along the tangent, y along the bitangent, z along the normal.
#ifdef MODE_GEMS
// Output: display colours of a published comparator, taken as scene-linear sRGB, in an arbitrary unit. They are not
// clamped. The result is zero where a direction is at or below the horizon.
#else
#ifdef COLOUR_THESIS
// Output: scene-linear radiance factor, relative to the peak of a mirror at normal incidence, in CIE RGB. It is not
// clamped, and it may be negative. It is zero where a direction is at or below the horizon.
#else
// Output: scene-linear radiance factor, relative to the peak of a mirror at normal incidence, with sRGB primaries. It
// is not clamped, and it is negative where a colour lies outside the primaries. It is zero where a direction is at or
// below the horizon.
#endif
#endif
#ifdef PATTERN
// Every function has a last argument `pattern` for the texel: cosine and sine of the angle by which the relief is turned,
// from the tangent towards the bitangent; its period and its depth relative to those of the surface.
#argument pattern: vec4f
#endif
// Tolerance and expected values: probe.json. Bindings, tables and units: manifest.json.
//- The writers of the other languages repeat this comment, up to the first other line, so that it is in ASCII.

#constants

#import gain
#ifdef MATERIAL
#ifdef SPECTRAL
#import matter
#endif
#endif
#ifdef MODE_FULL
#import nodes
#import series
#ifdef PREFILTERED
#import prefiltered
#else
#ifdef THESIS_LOOP
#import window
#import thesis
#else
#import bins
#import window
#import full
#endif
#endif
#endif
#ifdef MODE_PQ
#import nodes
#import series
#import bins
#import pq
#endif
#ifdef MODE_ADAPTIVE
#import series
#ifdef PREFILTERED
#import prefiltered
#import warped
#else
#import bins
#import adaptive
#endif
#endif
#ifdef MODE_BAKED
#import baked
#ifdef ENVIRONMENT
#import surroundings
#import cells
#endif
#ifdef PATH
#import colour_path
#endif
#endif
#ifdef MODE_GEMS
#import gems
#endif
#ifdef MODE_ORDERS
#import efficiencies
#import adaptive
#ifdef SIZED
#import arrivals
#endif
#ifdef LAMPS
#import lamps
#endif
#ifdef DISC
#import disc
#endif
#ifdef RECTANGLE
#import rectangle
#endif
#ifdef ENVIRONMENT
#import surroundings
#import environment
#endif
#ifdef PATH
#import order_path
#endif
#endif
#import colour
#import map
#import probe
#import mesh

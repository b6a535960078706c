// Diffraction of a height field: scene-linear radiance factor for a direction to the light and one to the viewer.
//
// Frame: x along the tangent, y along the bitangent, z along the normal. Directions are unit vectors that point away
// from the surface. Results are relative to the peak of a mirror at normal incidence, not clamped, and may be negative
// where a colour lies outside the primaries.
#constants
#import gain
#ifdef MODE_FULL
#import nodes
#import series
#ifdef PREFILTERED
#import prefiltered
#else
#import window
#import full
#endif
#endif
#ifdef MODE_PQ
#import nodes
#import series
#import pq
#endif
#ifdef MODE_ADAPTIVE
#import series
#ifdef PREFILTERED
#import prefiltered
#import warped
#else
#import adaptive
#endif
#endif
#ifdef MODE_BAKED
#import baked
#endif
#ifdef MODE_GEMS
#import gems
#endif
#import colour
#import map
#import probe
#import mesh

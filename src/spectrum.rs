//! Illuminant times observer, and the way from tristimulus values to linear sRGB.

//! The transforms of the basis functions of a surface.

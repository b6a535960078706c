//! Directions and the gain factor in front of the interference term.

//! Texel data of the tables that shaders read.

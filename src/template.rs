//! Strict specialisation of the WGSL templates, with a map back to their lines.

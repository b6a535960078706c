//! What a variant becomes on a surface: counts, hashes, static cost.

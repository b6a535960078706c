//! The windowed amplitude P(f; z), by brute force and fast, to 1e-9.

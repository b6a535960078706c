//! Ways to evaluate a variant.

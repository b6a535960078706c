//! Exact colours, the truth that everything else is compared with.

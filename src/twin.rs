//! The algorithms of the templates in f64, function by function.

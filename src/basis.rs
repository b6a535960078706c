//! Expansions of the phase function in products of a function of z and a function of h, with their bounds.

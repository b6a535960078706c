//! What each graphics API guarantees.

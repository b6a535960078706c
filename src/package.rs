//! The files of a package: written atomically, checked the same way.

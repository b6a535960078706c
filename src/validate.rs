//! External validators over emitted files.

//! Parsing, validation and lints of specialised WGSL.

//! One function per target language.

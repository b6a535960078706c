//! Diagnostics with places in templates, grouped over variants, for people and for machines.

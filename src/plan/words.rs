//! The words of a plan: which exist, and which of them this version builds.

use super::{
    Basis, Coherence, CoherenceScaling, Colour, Container, Level, Packing, Reconstruction,
    Sampling, TableFormat,
};

/// Words with what they mean; `None`: planned, not available in this version.
pub(super) type Words<T> = &'static [(&'static str, Option<T>)];

pub(super) const BASES: Words<Basis> = &[
    ("taylor", Some(Basis::Taylor)),
    ("taylor-zero", Some(Basis::TaylorZero)),
    ("chebyshev", Some(Basis::Chebyshev)),
    ("optimal", Some(Basis::Optimal)),
];

pub(super) const RECONSTRUCTIONS: Words<Reconstruction> =
    &[("window", Some(Reconstruction::Window)), ("prefiltered", Some(Reconstruction::Prefiltered))];

pub(super) const TABLE_FORMATS: Words<TableFormat> = &[
    ("f32", Some(TableFormat::F32)),
    ("f16", Some(TableFormat::F16)),
    ("rgb9e5", Some(TableFormat::Rgb9e5)),
];

/// `bin` stands for the raw texels, which are written whether it is named or not.
pub(super) const CONTAINERS: Words<Option<Container>> = &[
    ("bin", Some(None)),
    ("ktx2", Some(Some(Container::Ktx2))),
    ("exr", Some(Some(Container::Exr))),
];

pub(super) const PACKINGS: &[(&str, Packing)] =
    &[("paired", Packing::Paired), ("single", Packing::Single)];

pub(super) const SAMPLINGS: &[(&str, Sampling)] =
    &[("load", Sampling::Load), ("filter", Sampling::Filter)];

pub(super) const COHERENCES: &[(&str, Coherence)] =
    &[("single", Coherence::Single), ("ensemble", Coherence::Ensemble)];

pub(super) const SCALINGS: &[(&str, CoherenceScaling)] =
    &[("fixed", CoherenceScaling::Fixed), ("wavelength", CoherenceScaling::Wavelength)];

pub(super) const COLOURS: &[(&str, Colour)] = &[("srgb", Colour::Srgb), ("thesis", Colour::Thesis)];

pub(super) const LEVELS: &[(&str, Level)] =
    &[("none", Level::None), ("plane", Level::Plane), ("rows", Level::Rows)];

/// Stands for a number that is left to the tool.
pub(super) const AUTO: &[(&str, ())] = &[("auto", ())];

/// The words of a list.
pub(super) fn names<T>(words: &[(&'static str, T)]) -> Vec<&'static str> {
    words.iter().map(|(word, _)| *word).collect()
}

/// Why a planned word is refused.
pub(super) fn unavailable(key: &str, word: &str) -> String {
    format!("{key} \"{word}\" is not available in this version")
}

impl Basis {
    /// The word of the plan.
    pub fn as_str(self) -> &'static str {
        word_of(BASES, self)
    }
}

impl TableFormat {
    /// The word of the plan.
    pub fn as_str(self) -> &'static str {
        word_of(TABLE_FORMATS, self)
    }
}

impl Packing {
    /// The word of the plan.
    pub fn as_str(self) -> &'static str {
        match self {
            Packing::Paired => "paired",
            Packing::Single => "single",
        }
    }
}

impl Sampling {
    /// The word of the plan.
    pub fn as_str(self) -> &'static str {
        match self {
            Sampling::Load => "load",
            Sampling::Filter => "filter",
        }
    }
}

impl Container {
    /// The word of the plan, and the extension of the file.
    pub fn as_str(self) -> &'static str {
        word_of(CONTAINERS, Some(self))
    }
}

pub(super) fn word_of<T: Copy + PartialEq>(words: Words<T>, value: T) -> &'static str {
    words.iter().find(|(_, v)| *v == Some(value)).map_or("?", |(word, _)| word)
}

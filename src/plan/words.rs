//! The words of a plan, each with its meaning.

use super::{
    Basis, Coherence, CoherenceScaling, Colour, Container, Flip, Level, LightFunction, Obliquity,
    Packing, Reconstruction, Sampling, TableFormat, Trust, VoidValue,
};

/// Words with their meanings.
pub(super) type Words<T> = &'static [(&'static str, T)];

pub(super) const BASES: Words<Basis> = &[
    ("taylor", Basis::Taylor),
    ("taylor-zero", Basis::TaylorZero),
    ("chebyshev", Basis::Chebyshev),
    ("optimal", Basis::Optimal),
];

pub(super) const RECONSTRUCTIONS: Words<Reconstruction> =
    &[("window", Reconstruction::Window), ("prefiltered", Reconstruction::Prefiltered)];

pub(super) const TABLE_FORMATS: Words<TableFormat> =
    &[("f32", TableFormat::F32), ("f16", TableFormat::F16), ("rgb9e5", TableFormat::Rgb9e5)];

/// `bin` stands for the raw texels. They are always written, whether the plan lists `bin` or not.
pub(super) const CONTAINERS: Words<Option<Container>> =
    &[("bin", None), ("ktx2", Some(Container::Ktx2)), ("exr", Some(Container::Exr))];

pub(super) const PACKINGS: Words<Packing> =
    &[("paired", Packing::Paired), ("single", Packing::Single)];

pub(super) const SAMPLINGS: Words<Sampling> =
    &[("load", Sampling::Load), ("filter", Sampling::Filter)];

pub(super) const LIGHT_FUNCTIONS: Words<LightFunction> = &[
    ("direction", LightFunction::Direction),
    ("disc", LightFunction::Disc),
    ("polygon", LightFunction::Polygon),
    ("environment", LightFunction::Environment),
    ("path", LightFunction::Path),
];

pub(super) const COHERENCES: Words<Coherence> =
    &[("single", Coherence::Single), ("ensemble", Coherence::Ensemble)];

pub(super) const SCALINGS: Words<CoherenceScaling> =
    &[("fixed", CoherenceScaling::Fixed), ("wavelength", CoherenceScaling::Wavelength)];

pub(super) const OBLIQUITIES: Words<Obliquity> = &[
    ("stam", Obliquity::Stam),
    ("unpolarised", Obliquity::Unpolarised),
    ("te", Obliquity::Te),
    ("tm", Obliquity::Tm),
];

pub(super) const COLOURS: Words<Colour> = &[("srgb", Colour::Srgb), ("thesis", Colour::Thesis)];

pub(super) const LEVELS: Words<Level> =
    &[("none", Level::None), ("plane", Level::Plane), ("rows", Level::Rows)];

pub(super) const FLIPS: Words<Flip> =
    &[("none", Flip::None), ("rows", Flip::Rows), ("columns", Flip::Columns)];

pub(super) const TRUSTS: Words<Trust> = &[("file", Trust::File), ("plan", Trust::Plan)];

pub(super) const VOIDS: Words<VoidValue> = &[("none", VoidValue::None)];

/// `auto`: the tool chooses the number.
pub(super) const AUTO: Words<()> = &[("auto", ())];

/// The words without their meanings.
pub(super) fn names<T>(words: &[(&'static str, T)]) -> Vec<&'static str> {
    words.iter().map(|(word, _)| *word).collect()
}

impl Basis {
    /// The word of the plan.
    pub fn as_str(self) -> &'static str {
        word_of(BASES, self)
    }
}

impl Reconstruction {
    /// The word of the plan.
    pub fn as_str(self) -> &'static str {
        word_of(RECONSTRUCTIONS, self)
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
        word_of(PACKINGS, self)
    }
}

impl Sampling {
    /// The word of the plan.
    pub fn as_str(self) -> &'static str {
        word_of(SAMPLINGS, self)
    }
}

impl LightFunction {
    /// The word of the plan.
    pub fn as_str(self) -> &'static str {
        word_of(LIGHT_FUNCTIONS, self)
    }
}

impl Container {
    /// The word of the plan, and the extension of the file.
    pub fn as_str(self) -> &'static str {
        word_of(CONTAINERS, Some(self))
    }
}

pub(super) fn word_of<T: PartialEq>(words: Words<T>, value: T) -> &'static str {
    words.iter().find(|(_, known)| *known == value).map_or("?", |(word, _)| word)
}

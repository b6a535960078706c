//! A shader compiler for structural colour: from a height field to validated diffraction shaders with a stated error.
//!
//! ```
//! use std::path::Path;
//!
//! use diffraction_shaders::{Compiler, Plan};
//!
//! // a grating under sunlight, its colours in a table, as a shader for WebGPU
//! let plan = r#"
//! schema = 1
//! [[surface]]
//! name = "cd"
//! grating = { kind = "lamellar", period_um = 1.6, height_um = 0.12, duty = 0.5, pixels = 64 }
//! [variants]
//! mode = "baked"
//! bake_mib = 4
//! [targets]
//! emit = ["wgsl"]
//! "#;
//! let plan = Plan::parse(plan, Path::new("plan.toml"))?;
//! let package = Compiler::new(&plan).compile()?;
//! for (path, file) in package.files() {
//!     println!("{path}: {} bytes", file.content.byte_count()?);
//! }
//! # assert!(package.files().keys().any(|path| path.ends_with("diffraction.wgsl")), "{:?}", package.files().keys());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`package::write`] puts a package into a folder, and [`package::check`] compares a folder with a fresh package. Plans in
//! files are read by [`input::read_plan`], with the illuminants that they name.
//!
//! # The compiler's words
//!
//! - A **plan** says what is wanted: surfaces, variants, languages. [`plan`] reads it and names its axes.
//! - A **surface** is a height field with its scale: a scan, or a synthetic grating ([`surface`]).
//! - A **variant** is one configuration of the shader: a value for every **axis** ([`Variant`]).
//! - A **form** is how a variant computes on a surface: which loops, how many terms, which tables ([`variant::Form`]).
//! - A **table** is what shaders read: terms, spectra, baked colours ([`tables`]).
//! - A **target** is a language that is emitted ([`Target`]).
//! - A **package** holds shaders, tables, manifests, bindings and probes ([`Package`]); a **probe** is a direction with its
//!   colour, to test an integration with.
//! - A **gap** is a variant that a surface cannot have, with the reason ([`package::Gap`]).
//! - The **reference** is exact, in f64, and knows no variant ([`field::reference`]). A **twin** is the f64 copy of a variant's
//!   algorithm ([`variant::Twin`]). A **runner** evaluates by either ([`runner`]).
//!
//! The rooms below stand in the order of the pipeline: each uses only earlier ones.
//!
//! # Conventions
//!
//! - **Frame.** Normal `n = (0, 0, 1)`, `x` along the tangent, `y` along the bitangent. `wi` points from the surface to the
//!   light, `wr` to the viewer, both unit; `(u, v, w) = -wi - wr`, so `w` is in `[-2, 0]` and the mirror direction is
//!   `u = v = 0`.
//! - **Heights** are in µm, positive outwards. Row 0 is the top of the picture, `+y` is up: pixel (col, row) lies at
//!   `x = col·dx - Lx/2`, `y = (M-1-row)·dy - Ly/2`. The origin of all phases and of the coherence window is the centre of
//!   the patch, which tiles the plane.
//! - **Units.** µm inside formulas, nm for wavelengths in names; `k = 2π/λ`, `z = k·w`; spatial frequency
//!   `f = (u, v)/λ` in cycles per µm.
//! - **Transforms** are MATLAB's `ifft2`: `1/(NM) Σ … exp(+2πi …)`.
//! - **Coherence.** Gaussian window of standard deviation `σs = ℓc/4`; its spectrum has peak 1 and standard deviation
//!   `σf = 1/(2π σs)`. `single`: `|Σ_rs c_rs ĝ(f - f_rs)|²`; `ensemble`: `Σ_rs |c_rs|² ĝ(f - f_rs)²`.
//! - **ρ** is relative to a mirror at normal incidence in its mirror direction. Tristimulus values are relative to the
//!   illuminant's white, `Y = 1`; linear sRGB, white point D65, not clamped.
//! - **Matter** ([`optics::Matter`]). By default a dielectric in air. Under a cover of index n directions inside are
//!   `(α/n, ·)`, with α the xy part of a direction outside, and `z = k·n·w'` with `w'` inside; ρ stays relative to the
//!   material's mirror without its cover.
//!
//! # Limits of the model
//!
//! Scalar theory, single scattering. Directions of orders are always right. Their efficiencies in unpolarised light, beside
//! those of a rigorous solver: within 0.03 on a relief of 0.1 µm with a period of 2.5 µm, within 0.11 on a CD and 0.14 on a
//! DVD, wrong on reliefs that are deeper or finer (0.28 off at 0.25 µm in 1 µm); see [`field::rigorous`]. In one polarisation
//! the differences are about twice as large. Stam's obliquity factor is the mean, in amplitude, of the exact first-order TE
//! and TM factors. Without shadowing the gain diverges at grazing exit. A scan that is not periodic shows its seam as a
//! streak in `ensemble`, unless it is cropped to a near-period or tapered.
//!
//! # Sources
//!
//! J. Stam, *Diffraction shaders* (SIGGRAPH 1999), for the model; C. Schlick (1994) for the reflectance; K. Torrance and
//! E. Sparrow (1967) for V-cavities; CIE 015 and IEC 61966-2-1 for colour.

#![forbid(unsafe_code)]

pub mod error;
pub mod diagnostic;
pub mod hash;
pub mod disk;
pub mod random;
pub mod defines;
pub mod plan;
pub mod encode;
pub mod surface;
pub mod optics;
pub mod light;
pub mod pattern;
pub mod input;
pub mod field;
pub mod tables;
pub mod variant;
pub mod survey;
pub mod shader;
pub mod package;
pub mod runner;

pub use error::Error;
pub use package::Package;
pub use package::compile::Compiler;
pub use plan::{Plan, Target, Variant};
pub use runner::Runner;
pub use surface::HeightField;

//! Other shaders, for scale: they show what a variant's time means.

use diffraction_shaders::error::Result;
use diffraction_shaders::plan::{Mode, Optics, Variant};
use diffraction_shaders::runner::Placement;
use diffraction_shaders::shader::template::Sources;
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::tables::{SPECTRUM, Table, TexelFormat};
use diffraction_shaders::variant::{Form, Gems, Pattern};

use crate::drivers::Prepared;

/// A shader that is timed beside the variants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Yardstick {
    /// Only the gain: the minimum time of a frame.
    Empty,
    /// An ordinary material: one texel of base colour under a microfacet lobe (Walter et al. 2007; Schlick 1994).
    Ggx,
}

impl Yardstick {
    /// The name in records and tables.
    pub fn name(self) -> &'static str {
        match self {
            Yardstick::Empty => "empty",
            Yardstick::Ggx => "ggx",
        }
    }

    /// Texels that a pixel reads.
    pub fn fetches(self) -> f64 {
        match self {
            Yardstick::Empty => 0.0,
            Yardstick::Ggx => 1.0,
        }
    }

    /// The template in place of a mode's.
    fn template(self) -> &'static str {
        match self {
            Yardstick::Empty => EMPTY,
            Yardstick::Ggx => GGX,
        }
    }
}

const EMPTY: &str = "
fn tristimulus(wi: vec3f, wr: vec3f) -> vec3f {
    return vec3f(gain(wi, wr));
}
";

const GGX: &str = "
@group(0) @binding(2) var spectrum: texture_2d<f32>;

const ALPHA_SQUARED: f32 = 0.04;

fn tristimulus(wi: vec3f, wr: vec3f) -> vec3f {
    if (!(wi.z > 0.0 && wr.z > 0.0)) {
        return vec3f(0.0);
    }
    let size = vec2f(textureDimensions(spectrum));
    let base = textureLoad(spectrum, vec2i((0.5 + 0.4999 * wr.xy) * size), 0).xyz;
    let half_vector = normalize(wi + wr);
    let spread = half_vector.z * half_vector.z * (ALPHA_SQUARED - 1.0) + 1.0;
    let density = ALPHA_SQUARED / (3.1415927 * spread * spread);
    let masking = wi.z * sqrt(wr.z * wr.z * (1.0 - ALPHA_SQUARED) + ALPHA_SQUARED)
        + wr.z * sqrt(wi.z * wi.z * (1.0 - ALPHA_SQUARED) + ALPHA_SQUARED);
    let one_minus = 1.0 - dot(half_vector, wr);
    let squared = one_minus * one_minus;
    let fresnel = 0.04 + 0.96 * squared * squared * one_minus;
    return wi.z * (0.31830989 * (1.0 - fresnel) * base + vec3f(0.5 * density * fresnel / masking));
}
";

/// A metal with a texel of colour in the surroundings of a variant's shader: one look-up along the mirror image, as blurred as the
/// lobe, times the albedo of the lobe (Karis 2013, "Real shading in Unreal Engine 4", with his fit of 2014 in place of a table).
const GGX_IN_SURROUNDINGS: &str = "
fn ggx_in_surroundings(wr: vec3f) -> vec3f {
    let size = vec2f(textureDimensions(spectrum));
    let base = textureLoad(spectrum, vec2i((0.5 + 0.4999 * wr.xy) * size), 0).xyz;
    let light = environment_radiance(vec3f(-wr.xy, wr.z), GGX_SPREAD);
    let r = GGX_ROUGHNESS * vec4f(-1.0, -0.0275, -0.572, 0.022) + vec4f(1.0, 0.0425, 1.04, -0.04);
    let share = min(r.x * r.x, exp2(-9.28 * wr.z)) * r.x + r.y;
    let albedo = vec2f(-1.04, 1.04) * share + r.zw;
    return light * (base * albedo.x + albedo.y);
}
const GGX_ROUGHNESS: f32 = 0.4472136;
// of directions in the lobe, radians: twice the spread of its normals, whose tangents have alpha/sqrt(2) on each axis
const GGX_SPREAD: f32 = 0.2828427;
";

/// Adds the function of an ordinary material to the shader of a variant that has surroundings, and its base colour in place of the
/// spectrum table. Returns the call.
pub fn ggx_in_surroundings(prepared: &mut Prepared<'_>) -> &'static str {
    prepared.spectrum = base_colour();
    let map = prepared.sources.0.entry("map".to_owned()).or_default();
    map.push_str(GGX_IN_SURROUNDINGS);
    "ggx_in_surroundings(wr)"
}

/// Width and height of the base colour, in texels.
const TEXTURE: usize = 512;

/// The variant that the shader replaces: of the mode whose template needs no other template.
pub fn variant(what: Yardstick, optics: &Optics) -> Variant {
    Variant { name: what.name().to_owned(), mode: Mode::Gems, ..Variant::texts(optics) }
}

/// The shader and its texture, ready for a driver.
pub fn prepared<'a>(
    what: Yardstick,
    height: &'a HeightField,
    variant: &'a Variant,
) -> Result<Prepared<'a>> {
    let mut sources = Sources::builtin();
    sources.0.insert("gems".to_owned(), what.template().to_owned());
    Ok(Prepared {
        streaks: Table::ABSENT,
        paths: Table::ABSENT,
        // a rotation would read the spectrum table, whose place the base colour takes
        placement: Placement { height, rotate_deg: 0.0, variant },
        sources,
        form: Form::Gems(Gems::default()),
        terms: Table::ABSENT,
        spectrum: match what {
            Yardstick::Empty => Table::ABSENT,
            Yardstick::Ggx => base_colour(),
        },
        coefficients: Table::ABSENT,
        pattern: Pattern::NONE,
    })
}

/// A checkerboard of two browns, so that neighbouring pixels read different texels.
fn base_colour() -> Table {
    let texel = |i: usize| match (i / TEXTURE / 16 + i % TEXTURE / 16) % 2 {
        0 => [0.40, 0.22, 0.10, 1.0],
        _ => [0.15, 0.10, 0.06, 1.0],
    };
    Table {
        name: "spectrum",
        binding: SPECTRUM,
        format: TexelFormat::Rgba16Float,
        width: TEXTURE,
        height: TEXTURE,
        layers: 0,
        filtered: false,
        texels: (0..TEXTURE * TEXTURE).flat_map(texel).collect(),
    }
}

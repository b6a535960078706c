//! Compares a drawn picture with the same scene in f64.

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::light::{self, Filtered, Light};
use diffraction_shaders::optics::colour::from_rgb;
use diffraction_shaders::optics::colour_difference::{ColourDifference, colour_difference};
use diffraction_shaders::optics::{Matter, REFERENCE_NM};
use diffraction_shaders::tables::Table;
use diffraction_shaders::variant::mesh::{
    MeshParams, MeshVertex, OrientationMap, Vertex, in_frame, mesh as shaded, pattern_ratios,
};
use diffraction_shaders::variant::{Arguments, Around, Pattern, Twin};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::drivers::Prepared;
use crate::drivers::gpu::Gpu;
use crate::scene::lights::{irradiance, middle};
use crate::scene::surroundings::{Surroundings, filtered, turned};
use crate::scene::{Mesh, raster};

use super::{Used, axes, directions, lit_parts, relative_radiance};

/// The differences between a driver's picture and the scene in f64.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Truth {
    /// Number of pixels that both show.
    pub pixels: usize,
    /// Number of pixels on edges, where the two show different points, or only one shows the mesh. They are left out.
    pub edges: usize,
    /// Number of pixels whose point faces both the viewer and the middle of the first light.
    pub facing: usize,
    /// 95th percentile of the difference between the directions and those of the f64 rasteriser. A driver moves corners to a grid of
    /// 1/256 pixel.
    pub direction: f64,
    /// Maximum of that difference. It means little near the pole of a sphere, where interpolated tangents cancel.
    pub direction_max: f64,
    /// The picture against the twin's colours for the directions of the rasteriser.
    pub scene: ColourDifference,
    /// The picture against the twin's colours for the directions that the driver used.
    pub shading: ColourDifference,
    /// 95th percentile of the difference of a white body's radiance under the lights, divided by the maximum. `None` for the entry
    /// point `mesh`, which has no body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<f64>,
}

/// A pixel that both the driver and the rasteriser show.
struct Pixel {
    /// Its number.
    index: usize,
    /// The point that the rasteriser sees.
    at: MeshVertex,
    /// That of the next pixels, see [`raster::Seen`].
    next: [MeshVertex; 2],
    /// The directions that the driver used.
    used: Directions,
    /// The spread of lobes that the driver used.
    spread: f64,
}

/// Draws `mesh` by the entry point `mesh` of a variant, reads the directions that the driver used, and computes both again in
/// f64: directions from the vertices, and colours by the twin for both sets of directions.
pub fn truth(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    mesh: &Mesh,
    params: &MeshParams,
    size: [u32; 2],
) -> Result<Truth> {
    let drawn = relative_radiance(gpu, prepared, mesh, params, size)?;
    let scene = Scene::new(gpu, prepared, mesh, params, size)?;
    let (params, map) = (&scene.params, &scene.mesh.orientation);
    scene.compared(
        &|pixel| drawn[pixel.index],
        &|twin, pixel| shaded(twin, params, map, &pixel.at, &pixel.next),
        &|twin, pixel| {
            let call = Arguments::Spread { directions: pixel.used, spread: pixel.spread };
            on_texel(twin, map, &pixel.at, &|twin| {
                DVec3::from(twin.evaluate(call).unwrap_or_else(|| twin.tristimulus(pixel.used)))
            })
            .to_array()
        },
    )
}

/// The same for the colours that lights of any kind diffract, as scenes draw them, and for the radiance of a white body. `drawn`: the
/// lights that the driver gets, which are others only in negative controls.
pub fn truth_under(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    mesh: &Mesh,
    params: &MeshParams,
    [lights, drawn]: [&[Light]; 2],
    size: [u32; 2],
) -> Result<Truth> {
    let drawn = lit_parts(gpu, prepared, mesh, params, drawn, size)?;
    let frames = axes(gpu, prepared, mesh, params, size)?;
    let scene = Scene::new(gpu, prepared, mesh, params, size)?;
    let optics = &prepared.placement.variant.optics;
    let scale = prepared.form.diffuser_scale(optics).unwrap_or_default();
    let (eye, turns) = (scene.params.eye, &scene.mesh.orientation);
    let frame = |at: &MeshVertex| {
        let [x, y, z] = DVec3::AXES.map(|axis| in_frame(turns, axis, at));
        DMat3::from_cols(x, y, z)
    };
    let map = filtered(lights);
    let lit = |twin: &Twin<'_>, frame: DMat3, wr: DVec3| {
        let around = map.as_ref().map(|map| InFrame { map, to_frame: frame });
        let seen = around.as_ref().map(|around| around as &dyn light::Surroundings);
        let twin = &Twin { surroundings: seen, ..*twin };
        let each = lights.iter().filter(|light| !light.is_all_round());
        let each = each.map(|light| diffracted(twin, scale, light, frame, wr));
        let call = Arguments::Environment { around: Around::Host, wr };
        let all_round = seen.and_then(|_| twin.evaluate(call)).unwrap_or_default();
        each.sum::<DVec3>() + DVec3::from(all_round)
    };
    let compared = scene.compared(
        &|pixel| drawn[pixel.index].0,
        &|twin, pixel| {
            let wr = in_frame(turns, eye - pixel.at.place, &pixel.at);
            let colour = |twin: &Twin<'_>| lit(twin, frame(&pixel.at), wr);
            on_texel(twin, turns, &pixel.at, &colour).to_array()
        },
        &|twin, pixel| {
            let colour = |twin: &Twin<'_>| lit(twin, frames[pixel.index], pixel.used.wr);
            on_texel(twin, turns, &pixel.at, &colour).to_array()
        },
    )?;
    let matter = prepared.form.matter();
    let around = Surroundings::new(lights);
    let white = |pixel: &Pixel| {
        let wr = in_frame(turns, eye - pixel.at.place, &pixel.at);
        let to_frame = frame(&pixel.at);
        let covered = pattern_ratios(turns, pixel.at.uv).z;
        let each = lights.iter().map(|light| reflected(matter, covered, light, to_frame, wr));
        each.sum::<DVec3>() + reflected_around(matter, covered, around.as_ref(), to_frame, wr)
    };
    let whites: Vec<DVec3> = scene.pixels.iter().map(white).collect();
    let most = whites.iter().map(|white| white.max_element()).fold(f64::MIN_POSITIVE, f64::max);
    let apart = |(pixel, white): (&Pixel, &DVec3)| {
        (drawn[pixel.index].1.as_dvec3() - *white).abs().max_element()
    };
    let apart = scene.pixels.iter().zip(&whites).map(apart).collect();
    Ok(Truth { body: Some(sorted_p95(apart).0 / most), ..compared })
}

/// A map in the frame of a file of lights, seen from the frame of a pixel.
struct InFrame<'a> {
    map: &'a Filtered,
    to_frame: DMat3,
}

impl light::Surroundings for InFrame<'_> {
    fn seen(&self, direction: DVec3, spread_rad: f64) -> DVec3 {
        self.map.seen(turned(self.to_frame.transpose() * direction), spread_rad)
    }
}

/// Tristimulus values of the radiance that a light of the world diffracts, other than a sky or a map.
fn diffracted(twin: &Twin<'_>, scale: f64, light: &Light, to_frame: DMat3, wr: DVec3) -> DVec3 {
    if let Light::Direction { direction, irradiance } = light {
        let wi = to_frame * *direction;
        if !(wi.z > 0.0 && wr.z > 0.0) {
            return DVec3::ZERO;
        }
        let rho = DVec3::from(twin.tristimulus(Directions { wi, wr }));
        return scale / std::f64::consts::PI * *irradiance * rho;
    }
    let calls = Arguments::under(light, wr).into_iter();
    let calls = calls.map(|(call, factor)| {
        let call = match call {
            Arguments::Disc { axis, radius_rad, colour, wr } => {
                Arguments::Disc { axis: to_frame * axis, radius_rad, colour, wr }
            }
            Arguments::Rectangle { corners, colour, wr } => {
                let corners = corners.map(|corner| to_frame * corner);
                Arguments::Rectangle { corners, colour, wr }
            }
            Arguments::Direction(_)
            | Arguments::Spread { .. }
            | Arguments::Environment { .. }
            | Arguments::Path { .. } => call,
        };
        factor * DVec3::from(twin.evaluate(call).unwrap_or([f64::NAN; 3]))
    });
    calls.sum()
}

/// Radiance of a white body of this matter under a light of the world that is no sky and no map.
fn reflected(matter: &Matter, covered: f64, light: &Light, to_frame: DMat3, wr: DVec3) -> DVec3 {
    if wr.z <= 0.0 {
        return DVec3::ZERO;
    }
    let normal = to_frame.transpose() * DVec3::Z;
    let share = transmitted(matter, covered, to_frame * middle(light), wr);
    share / std::f64::consts::PI * irradiance(light, normal)
}

/// The same under all skies and maps, whose light counts as coming along the normal.
fn reflected_around(
    matter: &Matter,
    covered: f64,
    around: Option<&Surroundings>,
    to_frame: DMat3,
    wr: DVec3,
) -> DVec3 {
    match around {
        Some(around) if wr.z > 0.0 => {
            transmitted(matter, covered, DVec3::Z, wr)
                * around.white(to_frame.transpose() * DVec3::Z)
        }
        _ => DVec3::ZERO,
    }
}

/// The share of light that reaches the body, of which a part is covered by the relief.
fn transmitted(matter: &Matter, covered: f64, wi: DVec3, wr: DVec3) -> f64 {
    let half = (wi + wr).normalize_or_zero();
    let reflected = || matter.reflectances(REFERENCE_NM, half.dot(wr))[0];
    1.0 - covered * (1.0 - matter.body_share().unwrap_or_else(|| 1.0 - reflected()))
}

/// The colour of a point by the twin of its texel; what is not covered by the relief adds nothing.
fn on_texel(
    twin: &Twin<'_>,
    map: &OrientationMap,
    at: &MeshVertex,
    colour: &dyn Fn(&Twin<'_>) -> DVec3,
) -> DVec3 {
    // the frame has the angle of the map
    let [period_ratio, depth_ratio, covered] = pattern_ratios(map, at.uv).to_array();
    let form = twin.form.patterned(&Pattern { angle_deg: 0.0, period_ratio, depth_ratio });
    covered * colour(&Twin { form: &form, ..*twin })
}

/// A scene as a driver and as the rasteriser see it.
struct Scene<'a> {
    prepared: &'a Prepared<'a>,
    /// The tables as the driver got them.
    tables: Vec<Table>,
    /// The mesh with its numbers rounded as the driver got them.
    mesh: Mesh,
    params: MeshParams,
    pixels: Vec<Pixel>,
    edges: usize,
}

/// The tristimulus values of a pixel by the twin.
type Colour<'a> = &'a (dyn Fn(&Twin<'_>, &Pixel) -> [f64; 3] + Sync);

impl<'a> Scene<'a> {
    fn new(
        gpu: &Gpu,
        prepared: &'a Prepared<'a>,
        mesh: &Mesh,
        params: &MeshParams,
        size: [u32; 2],
    ) -> Result<Scene<'a>> {
        let used = directions(gpu, prepared, mesh, params, size)?;
        let (mesh, params) = (received(mesh), received_params(params));
        let seen = raster::visible(&mesh, &params, size)?;
        let (mut edges, mut pixels) = (0, Vec::new());
        for (index, (seen, used)) in seen.into_iter().zip(used).enumerate() {
            let (Some(seen), Some(Used { directions: used, away, spread })) = (seen, used) else {
                edges += usize::from(seen.is_some() != used.is_some());
                continue;
            };
            if (seen.at.place.distance(params.eye) - away).abs() > EDGE * away {
                edges += 1;
                continue;
            }
            pixels.push(Pixel { index, at: seen.at, next: seen.next, used, spread });
        }
        if pixels.is_empty() {
            let cause = "is not visible in any pixel, so nothing can be compared";
            return Err(Error::new(&mesh.name, cause));
        }
        let spectrum = (prepared.spectrum.width > 0).then_some(&prepared.spectrum);
        let tables = prepared.tables().chain(spectrum).map(|table| table.clone().rounded());
        let tables = tables.collect();
        Ok(Scene { prepared, tables, mesh, params, pixels, edges })
    }

    /// `drawn`: the driver's linear RGB; `exact` and `shading`: colours for the directions of the rasteriser, and for those that the
    /// driver used.
    fn compared(
        &self,
        drawn: &dyn Fn(&Pixel) -> [f32; 4],
        exact: Colour<'_>,
        shading: Colour<'_>,
    ) -> Result<Truth> {
        let subject = self.prepared.placement;
        let optics = &subject.variant.optics;
        let twin = Twin::new(&self.prepared.form, &self.tables, subject.rotate_deg);
        let (mut facing, mut apart) = (0, Vec::new());
        for Pixel { at, used, .. } in &self.pixels {
            let wi = in_frame(&self.mesh.orientation, self.params.light_direction, at);
            let wr = in_frame(&self.mesh.orientation, self.params.eye - at.place, at);
            facing += usize::from(wi.z > 0.0 && wr.z > 0.0);
            apart.push(wi.distance(used.wi).max(wr.distance(used.wr)));
        }
        let by_twin = |colour: Colour<'_>| -> Vec<[f64; 3]> {
            self.pixels.par_iter().map(|pixel| colour(&twin, pixel)).collect()
        };
        let rgb = |pixel: &Pixel| {
            let [r, g, b, _] = drawn(pixel).map(f64::from);
            from_rgb([r, g, b], optics.colour)
        };
        let picture: Vec<[f64; 3]> = self.pixels.iter().map(rgb).collect();
        let name = &self.mesh.name;
        let (direction, direction_max) = sorted_p95(apart);
        Ok(Truth {
            pixels: picture.len(),
            edges: self.edges,
            facing,
            direction,
            direction_max,
            scene: colour_difference(name, &by_twin(exact), &picture, None)?,
            shading: colour_difference(name, &by_twin(shading), &picture, None)?,
            body: None,
        })
    }
}

/// 95th percentile and maximum.
fn sorted_p95(mut numbers: Vec<f64>) -> (f64, f64) {
    numbers.sort_by(f64::total_cmp);
    let last = numbers.len() - 1;
    (numbers[last * 95 / 100], numbers[last])
}

/// Relative difference of distances above which a pixel counts as on an edge.
const EDGE: f64 = 1e-4;

/// The mesh with its numbers rounded as a driver gets them.
fn received(mesh: &Mesh) -> Mesh {
    let vertex = |v: &Vertex| Vertex {
        position: v.position.as_vec3().as_dvec3(),
        normal: v.normal.as_vec3().as_dvec3(),
        tangent: v.tangent.as_vec4().as_dvec4(),
        uv: v.uv.as_vec2().as_dvec2(),
        orientation_angle: f64::from(v.orientation_angle as f32),
    };
    Mesh { vertices: mesh.vertices.iter().map(vertex).collect(), ..mesh.clone() }
}

fn received_params(params: &MeshParams) -> MeshParams {
    MeshParams {
        model: params.model.as_mat4().as_dmat4(),
        view: params.view.as_mat4().as_dmat4(),
        projection: params.projection.as_mat4().as_dmat4(),
        light_direction: params.light_direction.as_vec3().as_dvec3(),
        eye: params.eye.as_vec3().as_dvec3(),
    }
}

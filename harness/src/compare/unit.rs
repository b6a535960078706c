//! One variant on one surface under one light: the exact colours, twins, routes, and routes against each other.

use diffraction_shaders::error::Result;
use diffraction_shaders::field::comparison_directions::{standard, under_lights};
use diffraction_shaders::optics::brdf_map::BrdfMap;
use diffraction_shaders::optics::colour_difference::{
    ColourDifference, auto_exposure, colour_difference, map_difference,
};
use diffraction_shaders::optics::{diffuser_scale, direction};
use diffraction_shaders::plan::Colour;
use diffraction_shaders::runner::{Exact, Placement, Runner, TwinRunner, radiance_with, rounded};
use diffraction_shaders::variant::tolerance_under;
use glam::DVec3;
use serde_json::Value;

use crate::drivers::Prepared;
use crate::drivers::routes::Route;
use crate::process::watched::{Place, child::enter};
use crate::results::{Compare, MapColours, Part, Record};

use super::{Job, Query, Shine, Sink, Truth, Unit, difference, failed, mean_flip};

/// Names of the two twins in records.
const TWIN: &str = "twin";
const UNPACKED: &str = "twin:unpacked";

/// Computes the exact colours and draws their map.
pub(super) fn truth(
    request: &Job<'_>,
    unit: &Unit<'_>,
    subject: Placement<'_>,
    number: usize,
    sink: &mut dyn Sink,
) -> Result<Truth> {
    let Placement { height, rotate_deg, variant } = subject;
    let optics = &variant.optics;
    let map = diffraction_shaders::optics::brdf_map::view_directions(unit.size).len();
    let (query, colours) = match unit.light {
        Shine::Direction([theta_deg, phi_deg]) => {
            let light: DVec3 = rounded(direction(theta_deg, phi_deg));
            let directions = standard(height, optics, rotate_deg, light, unit.size);
            let colours = Exact(subject).tristimulus(&directions)?;
            (Query::Direction { light, directions }, colours)
        }
        Shine::Lights(_, lights) => {
            let views = under_lights(height, optics, rotate_deg, lights, unit.size);
            let views: Vec<DVec3> = views.into_iter().map(rounded).collect();
            let scale = diffuser_scale(optics)?;
            let colours = radiance_with(&Exact(subject), scale, lights, &views, &|_| ())?;
            (Query::Lights { lights: lights.clone(), views }, colours)
        }
    };
    // a black surface has no exposure; the comparison reports that
    let exposure = request.exposure.or_else(|| auto_exposure(&colours)).unwrap_or(1.0);
    let map_exposure = request.exposure.or_else(|| auto_exposure(&colours[..map]));
    let picture = format!("pictures/{}/exact-{number}-{}.png", unit.surface, unit.light.place());
    let truth = Truth { query, map, colours, exposure, map_exposure, picture };
    let frame = truth.frame(&truth.colours, unit.size);
    let drawn = frame.png(Colour::Srgb, map_exposure.unwrap_or(exposure))?;
    sink.picture(&truth.picture, drawn)?;
    Ok(truth)
}

/// Compares one unit. `routes` has `None` for routes that do not take part.
pub(super) fn run(
    unit: &Unit<'_>,
    prepared: &Prepared<'_>,
    truth: &Truth,
    routes: &[Option<&dyn Route>],
    failures: &mut [u32],
    sink: &mut dyn Sink,
) -> Result<()> {
    let scale = diffuser_scale(&prepared.placement.variant.optics)?;
    let mut unit = Judged { unit, prepared, truth, sink };
    let ask = |packed| -> Result<Vec<[f64; 3]>> {
        truth.ask(&TwinRunner::new(prepared.placement, packed)?, scale, unit.unit.size)
    };
    let (unpacked, twin) = (ask(false)?, ask(true)?);
    unit.judge(Part::Model, (UNPACKED, &unpacked), ("exact", &truth.colours), None)?;
    unit.judge(Part::Packing, (TWIN, &twin), (UNPACKED, &unpacked), None)?;
    // the strip of pictures in a report shows the first route that draws, else the twin
    let mut drawn = routes.iter().all(Option::is_none);
    let exact = ("exact", truth.colours.as_slice());
    let pictures = match drawn {
        true => Some(unit.draw("", &truth.colours, &truth.picture, &twin)?),
        false => None,
    };
    unit.judge(Part::Total, (TWIN, &twin), exact, pictures)?;
    unit.sink.step();
    let mut found: Vec<(String, Vec<[f64; 3]>)> = Vec::new();
    for (route, failures) in routes.iter().zip(failures) {
        if let Some(route) = route {
            let name = route.name();
            enter(Place {
                route: name.clone(),
                surface: Some(unit.unit.surface.to_owned()),
                variant: Some(unit.unit.variant.name.clone()),
                light: match unit.unit.light {
                    Shine::Direction(angles) => Some(angles),
                    Shine::Lights(..) => None,
                },
            });
            match truth.ask(route.runner(prepared.clone()).as_ref(), scale, unit.unit.size) {
                Ok(colours) => {
                    *failures = 0;
                    let pictures = match std::mem::replace(&mut drawn, true) {
                        false => Some(unit.draw("", &truth.colours, &truth.picture, &colours)?),
                        true => None,
                    };
                    unit.judge(Part::Total, (&name, &colours), exact, pictures)?;
                    unit.judge(Part::Arithmetic, (&name, &colours), (TWIN, &twin), None)?;
                    found.push((name, colours));
                }
                Err(error) => {
                    *failures += 1;
                    let at = Some((unit.unit.surface, unit.unit.variant.name.as_str()));
                    unit.sink.record(failed(&name, at, &error.to_string()))?;
                }
            }
        }
        unit.sink.step();
    }
    unit.across(&found)
}

struct Judged<'a, 'b> {
    unit: &'a Unit<'a>,
    prepared: &'a Prepared<'b>,
    truth: &'a Truth,
    sink: &'a mut dyn Sink,
}

type Named<'a> = (&'a str, &'a [[f64; 3]]);

impl Judged<'_, '_> {
    /// Compares and records, and draws both sides if they disagree.
    fn judge(
        &mut self,
        part: Part,
        (route, colours): Named<'_>,
        (reference, expected): Named<'_>,
        pictures: Option<[String; 3]>,
    ) -> Result<()> {
        let Unit { surface, variant, light, size } = *self.unit;
        let subject = format!("{surface}: {}: {route}", variant.name);
        let measured =
            match colour_difference(&subject, expected, colours, Some(self.truth.exposure)) {
                Ok(measured) => measured,
                Err(error) => {
                    let gap = failed(route, Some((surface, &variant.name)), &error.to_string());
                    return self.sink.record(gap);
                }
            };
        let map = self.map_colours(&subject, expected, colours);
        let tolerance = match light {
            Shine::Direction(_) => self.prepared.form.promise().tolerance(part),
            Shine::Lights(_, lights) => tolerance_under(&self.prepared.form, lights, part),
        };
        let map_p95 = map.map_or(0.0, |map| map.de2000.p95);
        let pass =
            tolerance.is_none_or(|t| t.contains(measured.max_abs, [measured.de2000.p95, map_p95]));
        let frames = [expected, colours].map(|colours| self.truth.frame(colours, size));
        let pictures = match pictures {
            None if !pass => {
                let place = format!("{}-against-{}", safe(route), safe(reference));
                Some(self.draw(&place, expected, "", colours)?)
            }
            pictures => pictures,
        };
        self.sink.record(Record::Compare(Compare {
            surface: surface.to_owned(),
            variant: variant.name.clone(),
            route: route.to_owned(),
            reference: reference.to_owned(),
            part,
            light: light.lit(),
            size,
            exposure: measured.exposure,
            lit: measured.lit,
            max_abs: measured.max_abs,
            rms: measured.rms,
            de2000: measured.de2000,
            map,
            flip: self.truth.map_exposure.and_then(|e| mean_flip(&frames[0], &frames[1], e)),
            tolerance,
            pass,
            pictures,
            settings: serde_json::from_str(&variant.canonical()).unwrap_or(Value::Null),
        }))
    }

    /// Compares the map's pixels alone.
    fn map_colours(
        &self,
        subject: &str,
        expected: &[[f64; 3]],
        colours: &[[f64; 3]],
    ) -> Option<MapColours> {
        let exposure = self.truth.map_exposure?;
        let brightest = self.truth.colours.iter().map(|c| c[1]).fold(0.0, f64::max);
        let map = self.truth.map;
        let ColourDifference { lit, de2000, .. } =
            map_difference(subject, &expected[..map], &colours[..map], brightest, exposure)?;
        Some(MapColours { exposure, lit, de2000 })
    }

    /// Draws the reference (unless it has been drawn), the other side and their difference. Returns their paths.
    fn draw(
        &mut self,
        suffix: &str,
        expected: &[[f64; 3]],
        reference: &str,
        colours: &[[f64; 3]],
    ) -> Result<[String; 3]> {
        let Unit { surface, variant, light, size } = *self.unit;
        let [a, b] = [expected, colours].map(|colours| self.truth.frame(colours, size));
        let dash = if suffix.is_empty() { "" } else { "-" };
        let stem = format!("pictures/{surface}/{}/{}{dash}{suffix}", variant.name, light.place());
        let exposure = self.truth.map_exposure.unwrap_or(self.truth.exposure);
        let png = |map: &BrdfMap| map.png(Colour::Srgb, exposure);
        let reference = match reference {
            "" => {
                let place = format!("{stem}-reference.png");
                self.sink.picture(&place, png(&a)?)?;
                place
            }
            place => place.to_owned(),
        };
        let places = [reference, format!("{stem}.png"), format!("{stem}-difference.png")];
        self.sink.picture(&places[1], png(&b)?)?;
        self.sink.picture(&places[2], png(&difference(&a, &b))?)?;
        Ok(places)
    }

    /// Compares each route with the route that it differs from most.
    fn across(&mut self, found: &[(String, Vec<[f64; 3]>)]) -> Result<()> {
        for (i, (route, colours)) in found.iter().enumerate() {
            let others = found.iter().enumerate().filter(|(j, _)| i != *j).map(|(_, other)| other);
            let worst = others
                .map(|(name, other)| (max_difference(colours, other), name, other))
                .max_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, name, other)) = worst {
                self.judge(Part::Across, (route, colours), (name, other), None)?;
            }
        }
        Ok(())
    }
}

fn max_difference(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// A name as a part of a file's name.
pub(super) fn safe(route: &str) -> String {
    let keep = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    route.chars().map(keep).collect()
}

//! The scalar theory beside a rigorous solver: efficiencies of the orders of eight gratings.
//!
//! The solver's numbers are those of `rigorous/efficiencies.csv`; the README beside it says how they were made. The scalar
//! ones are shares of orders as in [`super::orders`], of the sampled relief and without shadowing. Both are efficiencies
//! inside the cover: the transmissions of its face are not in them.

use std::f64::consts::TAU;

use glam::DVec3;
use serde::Deserialize;

use crate::error::{Error, Result};
use crate::optics::{Matter, direction, reflectances};
use crate::plan::{Data, Grating, Material, Medium, Obliquity, Optics};
use crate::surface::HeightField;
use crate::surface::synthetic::synthesise;

use super::coefficient_brute;
use super::orders::whole_share;

/// Efficiencies by the solver, a line for each order and polarisation.
const TABLE: &str = include_str!("../../rigorous/efficiencies.csv");

/// Samples of a period. The efficiencies of the table's orders then err by less than 1e-4.
const PIXELS: usize = 1000;

/// Orders to which the solver gives less are not counted in a [`Departure`].
pub const WEAK: f64 = 0.01;

/// In the order of their declaration.
const OBLIQUITIES: [Obliquity; 4] =
    [Obliquity::Stam, Obliquity::Unpolarised, Obliquity::Te, Obliquity::Tm];

/// A grating of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Solved {
    /// Its name.
    pub name: String,
    /// The kind of its profile.
    pub profile: String,
    /// Period, µm.
    pub period_um: f64,
    /// Height, µm.
    pub height_um: f64,
    /// Share of the period that is high, of a lamellar profile.
    pub duty: Option<f64>,
    /// Its metal; `perfect` is a perfect conductor.
    pub metal: String,
    /// Its orders, each under one direction and at one wavelength.
    pub orders: Vec<SolvedOrder>,
}

/// An order of a grating under one direction, at one wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct SolvedOrder {
    /// Angle of the light in air, degrees. Angles are positive towards `+x`, across the grooves.
    pub theta_i_deg: f64,
    /// Angle of the order in air, degrees.
    pub theta_r_deg: f64,
    /// Wavelength in vacuum, nm.
    pub wavelength_nm: f64,
    /// Refractive index of the cover; 1 is air.
    pub cover_index: f64,
    /// The order `m`: `sin θr = -sin θi - m λ/d`.
    pub order: i64,
    rigorous: [f64; 2],
    scalar: [f64; 4],
}

/// How far the scalar theory is from the solver, over the orders of a grating.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departure {
    /// Number of orders.
    pub count: usize,
    /// Greatest absolute difference of efficiencies.
    pub worst: f64,
    /// Mean absolute difference of efficiencies.
    pub mean: f64,
}

#[derive(Deserialize)]
struct Line {
    grating: String,
    profile: String,
    period_um: f64,
    height_um: f64,
    duty: Option<f64>,
    metal: String,
    n: f64,
    k: f64,
    cover_index: f64,
    theta_i_deg: f64,
    polarisation: Polarisation,
    wavelength_nm: f64,
    order: i64,
    theta_r_deg: f64,
    efficiency: f64,
}

#[derive(Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Polarisation {
    Te,
    Tm,
}

impl Solved {
    /// How far the scalar theory is from the solver in all orders to which the solver gives more than [`WEAK`].
    pub fn departure(&self, of: Obliquity) -> Departure {
        let pairs = self.orders.iter().map(|order| order.efficiencies(of));
        let strong = pairs.filter(|[rigorous, _]| *rigorous > WEAK);
        let all: Vec<f64> = strong.map(|[rigorous, scalar]| (scalar - rigorous).abs()).collect();
        let worst = all.iter().copied().fold(0.0, f64::max);
        let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
        Departure { count: all.len(), worst, mean }
    }
}

impl SolvedOrder {
    /// The rigorous and the scalar efficiency, of the light that an obliquity is for: the electric field along the grooves,
    /// the magnetic field along the grooves, or unpolarised.
    pub fn efficiencies(&self, of: Obliquity) -> [f64; 2] {
        let [te, tm] = self.rigorous;
        let rigorous = match of {
            Obliquity::Te => te,
            Obliquity::Tm => tm,
            Obliquity::Stam | Obliquity::Unpolarised => 0.5 * (te + tm),
        };
        [rigorous, self.scalar[of as usize]]
    }
}

/// All gratings of the table.
pub fn solved() -> Result<Vec<Solved>> {
    let lines = csv::Reader::from_reader(TABLE.as_bytes()).into_deserialize();
    let lines: Vec<Line> =
        lines.collect::<Result<_, _>>().map_err(|e| fault("is no table").source(e))?;
    lines.chunk_by(|a, b| a.grating == b.grating).map(grating).collect()
}

fn fault(cause: &str) -> Error {
    Error::new("efficiencies.csv", cause)
}

/// A grating from its lines.
fn grating(lines: &[Line]) -> Result<Solved> {
    let first = &lines[0];
    let relief = relief(first)?;
    let matters = OBLIQUITIES.map(|obliquity| matter(lines, obliquity));
    let matters: Vec<Matter> = matters.into_iter().collect::<Result<_>>()?;
    let order = |te: &Line| {
        let place = |line: &Line| (line.theta_i_deg, line.wavelength_nm, line.order);
        let is_other =
            |line: &&Line| line.polarisation == Polarisation::Tm && place(line) == place(te);
        let tm = lines.iter().find(is_other).ok_or_else(|| fault("has an order without TM"))?;
        Ok(SolvedOrder {
            theta_i_deg: te.theta_i_deg,
            theta_r_deg: te.theta_r_deg,
            wavelength_nm: te.wavelength_nm,
            cover_index: te.cover_index,
            order: te.order,
            rigorous: [te.efficiency, tm.efficiency],
            scalar: scalar(te, &relief, &matters),
        })
    };
    Ok(Solved {
        name: first.grating.clone(),
        profile: first.profile.clone(),
        period_um: first.period_um,
        height_um: first.height_um,
        duty: first.duty,
        metal: first.metal.clone(),
        orders: lines
            .iter()
            .filter(|line| line.polarisation == Polarisation::Te)
            .map(order)
            .collect::<Result<_>>()?,
    })
}

fn relief(line: &Line) -> Result<HeightField> {
    let Line { period_um, height_um, .. } = *line;
    let pixels = PIXELS;
    let profile = match (line.profile.as_str(), line.duty) {
        ("sinusoidal", _) => Grating::Sinusoidal { period_um, height_um, pixels },
        ("blazed", _) => Grating::Blazed { period_um, height_um, pixels },
        ("lamellar", Some(duty)) => Grating::Lamellar { period_um, height_um, pixels, duty },
        _ => return Err(fault("has a profile that is not known")),
    };
    Ok(synthesise(&profile, &line.grating)?.field)
}

/// Metal and cover of a grating's lines.
fn matter(lines: &[Line], obliquity: Obliquity) -> Result<Matter> {
    let has_cover = lines.iter().any(|line| line.cover_index != 1.0);
    // an imaginary index reflects all light, as a perfect conductor; tables hold no greater one, and none without n
    let metal = table(lines, |line| [line.n.max(1e-9), line.k.min(100.0)]);
    let cover = table(lines, |line| [line.cover_index, 0.0]);
    Matter::new(&Optics {
        material: Material::Medium(metal),
        cover_index: if has_cover { cover } else { Medium::Constant(1.0) },
        obliquity,
        shadowing: false,
        ..Optics::standard()
    })
}

/// A medium that has the n and k of the lines at their wavelengths.
fn table(lines: &[Line], index: impl Fn(&Line) -> [f64; 2]) -> Medium {
    let mut rows: Vec<(f64, [f64; 2])> =
        lines.iter().map(|line| (line.wavelength_nm, index(line))).collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    rows.dedup_by_key(|row| row.0);
    // it must cover visible light
    let (first, last) = (rows[0].1, rows[rows.len() - 1].1);
    let all = [(300.0, first)].into_iter().chain(rows).chain([(900.0, last)]);
    let text: String = all.map(|(nm, [n, k])| format!("{nm},{n},{k}\n")).collect();
    let text = format!("wavelength_nm,n,k\n{text}");
    Medium::File(Data::new("efficiencies.csv").with_content(text.into_bytes()))
}

/// Efficiencies by the scalar theory, for each of [`OBLIQUITIES`].
fn scalar(line: &Line, relief: &HeightField, matters: &[Matter]) -> [f64; 4] {
    let lambda_nm = line.wavelength_nm;
    let wi = direction(line.theta_i_deg, 0.0);
    let across = -wi.x - line.order as f64 * lambda_nm * 1e-3 / line.period_um;
    let wr = DVec3::new(across, 0.0, (1.0 - across * across).max(0.0).sqrt());
    let z = TAU / (lambda_nm * 1e-3) * matters[0].depth(wi, wr, lambda_nm);
    let square = coefficient_brute(relief, line.order, 0, z).norm_sqr();
    // what the cover's face lets pass, of both polarisations
    let passed =
        |cos: f64| reflectances(1.0, cos, &[], line.cover_index.into(), lambda_nm).map(|r| 1.0 - r);
    let (inwards, outwards) = (passed(wi.z), passed(wr.z));
    let mean = |[s, p]: [f64; 2]| 0.5 * (s + p);
    OBLIQUITIES.map(|obliquity| {
        let faces = match obliquity {
            Obliquity::Te => inwards[0] * outwards[0],
            Obliquity::Tm => inwards[1] * outwards[1],
            Obliquity::Stam | Obliquity::Unpolarised => mean(inwards) * mean(outwards),
        };
        whole_share(&matters[obliquity as usize], wi, wr, lambda_nm) * square / faces
    })
}

//! A variant, or the exact reference, on a surface or a window of it.

use anyhow::Result;
use diffraction_cli::args::{Runner, RunnerArgs};
use diffraction_cli::memory;
use diffraction_cli::runners::Job;
use diffraction_shaders::field::reference::{Reference, Span};
use diffraction_shaders::optics::Matter;
use diffraction_shaders::plan::{Mode, Plan, SurfaceSource, SurfaceSpec, Variant, Wavelengths};
use diffraction_shaders::surface::facts::facts;
use diffraction_shaders::surface::{HeightField, Surface, subject};
use diffraction_shaders::variant::Form;

use super::Args;
use crate::commands::drivers;
use crate::period::{self, Crop, Measurement, Protocol};
use crate::results::{Gap, Testbench};

/// A variant or the reference, to be measured.
pub(super) struct Task {
    /// The variant's name, or `exact`.
    pub(super) name: String,
    variant: Variant,
    runner: RunnerArgs,
}

/// The result of a measurement.
pub(super) struct Found {
    pub(super) variant: String,
    pub(super) route: String,
    pub(super) protocol: Protocol,
    pub(super) measurement: Measurement,
    /// The same measurement on the closed form.
    pub(super) yardstick: Option<Measurement>,
}

/// The reference and variants that the options name, and gaps for those that cannot be measured.
pub(super) fn tasks(args: &Args, plan: &Plan) -> Result<(Vec<Task>, Vec<Gap>)> {
    let (mut tasks, mut gaps) = (Vec::new(), Vec::new());
    if args.only_exact() || args.variant.is_none() {
        let runner = runner(args, Runner::Exact);
        tasks.push(Task { name: "exact".into(), variant: Variant::texts(&plan.optics), runner });
    }
    let variants = match &args.variant {
        _ if args.only_exact() => vec![],
        Some(name) => vec![plan.variant(Some(name))?],
        None => plan.variants.clone(),
    };
    for variant in variants {
        let name = variant.name.clone();
        match not_applicable(&variant, args.wavelengths.0) {
            Some(reason) => {
                gaps.push(gap(&args.surface.surface, &name, args.runner_name(), reason));
            }
            None => tasks.push(Task { name, variant, runner: runner(args, args.runner()) }),
        }
    }
    Ok((tasks, gaps))
}

/// A record of a variant that was not measured.
pub(super) fn gap(surface: &str, variant: &str, route: String, reason: String) -> Gap {
    Gap {
        route,
        surface: Some(surface.to_owned()),
        variant: Some(variant.to_owned()),
        reason,
        failed: false,
    }
}

fn not_applicable(variant: &Variant, asked: Wavelengths) -> Option<String> {
    if matches!(variant.mode, Mode::Gems | Mode::Baked) {
        let mode = variant.mode.as_str();
        return Some(format!("not applicable: the mode {mode} has no wavelength axis"));
    }
    let own = variant.wavelengths;
    (asked.min_nm < own.min_nm || asked.max_nm > own.max_nm).then(|| {
        format!(
            "not applicable: covers {} to {} nm (--wavelengths {0},{1},{})",
            own.min_nm, own.max_nm, asked.step_nm
        )
    })
}

fn runner(args: &Args, runner: Runner) -> RunnerArgs {
    let unpacked = args.unpacked && runner != Runner::Exact;
    let unchecked = args.unchecked;
    RunnerArgs {
        variant: None,
        runner,
        unpacked,
        adapter: args.adapter.clone(),
        unchecked,
        pattern: None,
    }
}

/// Whether the patch tiles without a seam along x and y. Synthetic patches do.
pub(super) fn tiled(spec: &SurfaceSpec, field: &HeightField) -> Result<[bool; 2]> {
    let synthetic = matches!(spec.source, SurfaceSource::Grating(_));
    Ok(facts(field, &subject(spec))?.joins.map(|joins| joins || synthetic))
}

impl Task {
    /// Why the variant cannot be built on these heights, if so.
    pub(super) fn refusal(&self, field: &HeightField) -> Option<String> {
        let applies = self.runner.runner != Runner::Exact;
        let refused = applies.then(|| Form::new(&self.variant, field).err()).flatten();
        refused.map(|error| format!("not applicable: {error}"))
    }

    /// Bytes that measuring takes beside the heights.
    pub(super) fn memory(&self, field: &HeightField) -> Result<u64> {
        Ok(match self.runner.runner {
            Runner::Exact => {
                let optics = &self.variant.optics;
                Reference::working_bytes(field, optics, &Matter::new(optics)?, Span::ANYWHERE)
            }
            Runner::Twin => memory::of(field, &self.variant)?.to_evaluate(),
            _ => memory::of(field, &self.variant)?.to_check_and_draw(),
        })
    }

    /// The heights of the whole surface, or of a window.
    pub(super) fn field(surface: &Surface, crop: Option<Crop>) -> Result<HeightField> {
        Ok(match crop {
            Some(crop) => crop.of(&surface.field)?,
            None => surface.field.clone(),
        })
    }

    /// Measures the surface or a window of it.
    pub(super) fn measure(
        &self,
        spec: &SurfaceSpec,
        field: HeightField,
        is_whole: bool,
        protocol: &Protocol,
    ) -> Result<Found> {
        let surface = Surface { field, notes: vec![] };
        let job = Job { spec: spec.clone(), surface, variant: self.variant.clone() };
        let (placement, protocol) = (job.placement(), *protocol);
        let extent_um = period::extent_um(placement, protocol.wavelengths.max_nm)?;
        let runner = job.runner(&self.runner, drivers::open)?;
        let measurement = if self.runner.runner == Runner::Exact {
            period::measure(&protocol, extent_um, period::exact(placement, protocol)?)?
        } else {
            let respond = period::runner(runner.as_ref(), protocol);
            period::measure(&protocol, extent_um, respond)?
        };
        let yardstick = match (&spec.source, is_whole) {
            (SurfaceSource::Grating(grating), true) => {
                period::yardstick(grating, placement, &protocol)?
            }
            _ => None,
        };
        let (variant, route) = (self.name.clone(), runner.route());
        Ok(Found { variant, route, protocol, measurement, yardstick })
    }
}

impl Found {
    /// The result as a record.
    pub(super) fn record(
        &self,
        surface: &str,
        crop: Option<Crop>,
        svg: Option<String>,
    ) -> Testbench {
        let m = &self.measurement;
        let closed = self.yardstick.as_ref().filter(|closed| closed.points > 0);
        Testbench {
            surface: surface.to_owned(),
            variant: self.variant.clone(),
            route: self.route.clone(),
            theta_i: self.protocol.theta_i_deg,
            phi_i: self.protocol.phi_i_deg,
            expected_nm: 1e3 * self.protocol.expected_um,
            period_nm: m.period_nm,
            sd_nm: m.sd_nm,
            points: m.points,
            evanescent: m.evanescent,
            flat: m.flat,
            closed_nm: closed.map(|closed| [closed.period_nm, closed.sd_nm]),
            window: crop.map(Crop::to_array),
            windows: None,
            weight: m.weight,
            svg,
        }
    }
}

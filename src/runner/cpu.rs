//! Evaluation in f64 on all cores.

use glam::DVec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::field::orders::OrderSum;
use crate::field::reference::{Directions, Reference, evaluate_all};
use crate::light::Light;
use crate::shader::specialise;
use crate::tables::Table;
use crate::variant::{Arguments, Form, Pattern, Twin};

use super::{Placement, Progress, Runner, has_wavelengths, lit_by};

/// The exact reference. It uses only the optics of the variant.
pub struct Exact<'a>(pub Placement<'a>);

impl Exact<'_> {
    fn reference(&self, range_nm: (f64, f64), directions: &[Directions]) -> Result<Reference> {
        let Placement { height, rotate_deg, variant } = self.0;
        Reference::new(height, rotate_deg, &variant.optics, range_nm, directions.iter().copied())
    }
}

impl Runner for Exact<'_> {
    fn route(&self) -> String {
        "exact".to_owned()
    }

    fn tristimulus_with(
        &self,
        directions: &[Directions],
        progress: Progress<'_>,
    ) -> Result<Vec<[f64; 3]>> {
        Ok(self
            .reference(Reference::VISIBLE_NM, directions)?
            .tristimulus_all_with(directions, progress))
    }

    fn tinted(
        &self,
        directions: &[Directions],
        colour: DVec3,
        progress: Progress<'_>,
    ) -> Result<Vec<[f64; 3]>> {
        let reference = self.reference(Reference::VISIBLE_NM, directions)?;
        Ok(reference.tinted(colour).tristimulus_all_with(directions, progress))
    }

    fn response(&self, directions: &[Directions], lambda_nm: f64) -> Result<Vec<f64>> {
        let reference = self.reference((lambda_nm, lambda_nm), directions)?;
        let response = |d, scratch: &mut _| [reference.response(d, lambda_nm, scratch), 0.0, 0.0];
        Ok(evaluate_all(directions, &|_| (), response).into_iter().map(|r| r[0]).collect())
    }

    fn under(
        &self,
        light: &Light,
        views: &[DVec3],
        progress: Progress<'_>,
    ) -> Result<Vec<[f64; 3]>> {
        let Placement { height, rotate_deg, variant } = self.0;
        let Some(emitter) = light.emitter() else {
            let cause = "a light of one direction has no size";
            return Err(Error::new(self.route(), cause));
        };
        let orders = OrderSum::new(height, rotate_deg, &variant.optics)?;
        Ok(orders.radiance_all_with(&[&*emitter], views, progress))
    }
}

/// The f64 copy of the variant's template, with the variant's tables.
pub struct TwinRunner<'a> {
    placement: Placement<'a>,
    form: Form,
    tables: Vec<Table>,
    /// Angle of the pattern.
    angle_deg: f64,
}

impl<'a> TwinRunner<'a> {
    /// Computes the tables. `packed`: round them to the numbers that the shader reads.
    pub fn new(placement: Placement<'a>, packed: bool) -> Result<TwinRunner<'a>> {
        let Placement { height, rotate_deg, variant } = placement;
        let form = Form::new(variant, height)?;
        let round = |table: Table| if packed { table.rounded() } else { table };
        let tables = specialise::tables(&form, height, rotate_deg)?;
        let tables = tables.into_iter().map(round).collect();
        Ok(TwinRunner { placement, form, tables, angle_deg: 0.0 })
    }

    /// The same for a texel of a pattern.
    #[must_use]
    pub fn patterned(self, pattern: &Pattern) -> TwinRunner<'a> {
        let (form, angle_deg) = (self.form.patterned(pattern), pattern.angle_deg);
        TwinRunner { form, angle_deg, ..self }
    }

    fn twin(&self) -> Twin<'_> {
        Twin::new(&self.form, &self.tables, self.placement.rotate_deg + self.angle_deg)
    }
}

impl Runner for TwinRunner<'_> {
    fn route(&self) -> String {
        "twin".to_owned()
    }

    fn tristimulus_with(
        &self,
        directions: &[Directions],
        progress: Progress<'_>,
    ) -> Result<Vec<[f64; 3]>> {
        let twin = self.twin();
        Ok(evaluate_all(directions, progress, |d, (): &mut ()| twin.tristimulus(d)))
    }

    fn under(
        &self,
        light: &Light,
        views: &[DVec3],
        progress: Progress<'_>,
    ) -> Result<Vec<[f64; 3]>> {
        let around = light.surroundings();
        let twin = Twin { surroundings: around.as_deref(), ..self.twin() };
        lit_by(&self.placement.variant.name, &self.form, light, views, &|calls| {
            let result = |call: &Arguments| twin.evaluate(*call).unwrap_or([f64::NAN; 3]);
            let results = calls.par_iter().map(result).collect();
            progress(views.len());
            Ok(results)
        })
    }

    fn response(&self, directions: &[Directions], lambda_nm: f64) -> Result<Vec<f64>> {
        has_wavelengths(&self.placement.variant.name, &self.form)?;
        let twin = self.twin();
        let response = |d: Directions, (): &mut ()| {
            let path = self.form.matter().path(d.wi, d.wr, twin.rotate_deg);
            [twin.response(path, lambda_nm * 1e-3).unwrap_or(0.0), 0.0, 0.0]
        };
        Ok(evaluate_all(directions, &|_| (), response).into_iter().map(|r| r[0]).collect())
    }
}

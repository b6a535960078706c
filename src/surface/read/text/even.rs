//! Evenly spaced coordinates.

/// A coordinate may lie this share of a step beside its place: files round coordinates.
const TOLERANCE: f64 = 0.1;

/// Evenly spaced coordinates: the first, and the step to the next, which is negative if they fall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Even {
    pub first: f64,
    pub step: f64,
}

impl Even {
    /// The spacing of at least two coordinates, if they rise or fall evenly.
    pub fn of(values: &[f64]) -> Option<Even> {
        Even::within(values, TOLERANCE)
    }

    /// The same, each coordinate at most `tolerance` steps beside its place.
    pub fn within(values: &[f64], tolerance: f64) -> Option<Even> {
        let [first, .., last] = *values else { return None };
        let step = (last - first) / (values.len() - 1) as f64;
        let is_even = step != 0.0
            && step.is_finite()
            && values
                .iter()
                .enumerate()
                .all(|(i, v)| ((v - first) / step - i as f64).abs() <= tolerance);
        is_even.then_some(Even { first, step })
    }

    /// The place of a coordinate among `count`.
    pub fn place(&self, value: f64, count: usize) -> Option<usize> {
        let place = ((value - self.first) / self.step).round();
        (place >= 0.0 && place < count as f64).then_some(place as usize)
    }
}

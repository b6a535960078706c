//! Interleaved rounds. Each round draws every subject of a group once, so that other load of the machine slows all of them
//! alike. Ratios are formed within a round only.

use std::time::Duration;

use diffraction_shaders::error::Result;

use super::clock::{Clock, ms};
use super::stats::{self, MIN_VALUES, median, relative_width};

/// Draws frames and measures their time.
pub trait Executor {
    /// Draws `frames` frames one after another.
    fn draw(&mut self, frames: usize) -> Result<Drawn>;
}

/// Time of several frames together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drawn {
    /// From submission until the driver reports the end.
    pub wall: Duration,
    /// Between the driver's time stamps; `None` without time stamps.
    pub stamps: Option<Duration>,
}

/// When to stop measuring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Target precision: half of the width of the ratio's confidence interval, over the ratio.
    pub precision: f64,
    /// Time for each subject, without warm-up. A round that has begun is finished.
    pub budget: Duration,
    /// Minimum number of rounds, whatever the budget.
    pub min_rounds: usize,
    /// Maximum number of rounds, whatever the precision.
    pub max_rounds: usize,
}

impl Rules {
    /// A precision of 2 % in 6 to 60 rounds.
    pub fn standard(budget: Duration) -> Rules {
        Rules { precision: 0.02, budget, min_rounds: MIN_VALUES, max_rounds: 60 }
    }
}

/// The clock of a group's times. All times of a group are from one clock, so that ratios are meaningful.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timing {
    /// The driver's time stamps, if they agree with the wall clock for every subject.
    Stamps,
    /// The wall clock, from submission to the end.
    Wall,
}

impl Timing {
    /// The name in records.
    pub fn name(self) -> &'static str {
        match self {
            Timing::Stamps => "timestamps",
            Timing::Wall => "wall",
        }
    }
}

/// The measurements of one subject. Times are in ms for one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// Number of frames in a round.
    pub frames: usize,
    /// The round of each value below.
    pub rounds: Vec<usize>,
    /// Time by the group's clock.
    pub time_ms: Vec<f64>,
    /// Processor time, all threads.
    pub cpu_ms: Vec<f64>,
    /// `|time stamps / wall - 1|` while warming up; `None` without time stamps.
    pub disagreement: Option<f64>,
}

/// The samples of a group, in the order of its subjects.
#[derive(Debug)]
pub struct Measured {
    /// The clock.
    pub timing: Timing,
    /// The samples, or what went wrong.
    pub samples: Vec<Result<Samples>>,
}

/// Minimum time for which a round draws a subject, in ms: a frame of 2 ms is drawn twenty times.
const ROUND_MS: f64 = 40.0;
/// Minimum of the same time as a share of the longest frame. A short draw may meet the machine only busy or only idle.
const MIN_SHARE: f64 = 0.25;
/// Maximum number of frames of a subject in a round.
const MAX_FRAMES: f64 = 20.0;
/// Maximum relative difference of time stamps from the wall clock. With a larger one they are not used …
const AGREEMENT: f64 = 0.05;
/// … unless the difference is below this cost of a submission, in ms.
const SUBMISSION_MS: f64 = 0.5;
/// Draws shorter than this, in ms, are compared again before a difference counts: other work may have come between the last
/// time stamp and the wall clock's.
const CHEAP_MS: f64 = 500.0;
const RETRIES: usize = 2;

/// Measures a group. The first subject is the baseline of the ratios: it is drawn as long as any other is.
///
/// Each subject is drawn once to estimate its time, and once more to warm up and to compare clocks. A frame below 40 ms, or
/// much shorter than the longest, is drawn several times in a round, a frame below 2 ms twenty times. The order changes from
/// round to round. A subject leaves when the interval of its ratio is narrow enough, or with its error when it fails.
/// `stop` is called before every draw; the results of whole rounds are kept. `progress` gets the spent share of the
/// allowed time.
pub fn measure(
    subjects: &mut [Box<dyn Executor + '_>],
    clock: &dyn Clock,
    rules: &Rules,
    progress: &dyn Fn(f64),
    stop: &dyn Fn() -> bool,
) -> Measured {
    let (timing, mut samples) = warm_up(subjects, stop);
    let budget = rules.budget * subjects.len() as u32;
    let begun = clock.wall();
    for round in 0..rules.max_rounds {
        let spent = clock.wall() - begun;
        progress((spent.as_secs_f64() / budget.as_secs_f64()).min(1.0));
        let active = active(&samples, round, rules);
        if active.is_empty() || stop() || (spent >= budget && round >= rules.min_rounds) {
            break;
        }
        for index in order(&active, round) {
            if stop() {
                break;
            }
            let Ok(sample) = &mut samples[index] else { continue };
            let cpu = clock.cpu();
            match subjects[index].draw(sample.frames) {
                Ok(drawn) => sample.push(round, drawn, timing, clock.cpu() - cpu),
                Err(error) => samples[index] = Err(error),
            }
        }
    }
    progress(1.0);
    Measured { timing, samples }
}

/// Values of `baseline` divided by the values of `other`, round by round.
pub fn ratios(baseline: &Samples, other: &Samples) -> Vec<f64> {
    let of = |round: usize, time: f64| {
        let place = baseline.rounds.iter().position(|at| *at == round)?;
        Some(baseline.time_ms[place] / time)
    };
    other.rounds.iter().zip(&other.time_ms).filter_map(|(&round, &time)| of(round, time)).collect()
}

impl Samples {
    fn push(&mut self, round: usize, drawn: Drawn, timing: Timing, cpu: Duration) {
        let time = match timing {
            Timing::Stamps => drawn.stamps.unwrap_or(drawn.wall),
            Timing::Wall => drawn.wall,
        };
        let frames = self.frames as f64;
        self.rounds.push(round);
        // a coarse clock must not make a ratio infinite
        self.time_ms.push(ms(time).max(1e-6) / frames);
        self.cpu_ms.push(ms(cpu) / frames);
    }
}

fn warm_up(
    subjects: &mut [Box<dyn Executor + '_>],
    stop: &dyn Fn() -> bool,
) -> (Timing, Vec<Result<Samples>>) {
    let lengths: Vec<Result<f64>> = subjects.iter_mut().map(|s| length(&mut **s, stop)).collect();
    let longest = lengths.iter().flatten().copied().fold(0.0, f64::max);
    let mut agree = true;
    let mut warm = |subject: &mut dyn Executor, once: f64| {
        let frames = (ROUND_MS.max(MIN_SHARE * longest) / once.max(1e-3)).ceil();
        let frames = frames.clamp(1.0, MAX_FRAMES) as usize;
        if stop() {
            return Ok(Samples { frames, ..Samples::default() });
        }
        let mut seen = paired(subject.draw(frames)?);
        for _ in 0..RETRIES {
            if seen.is_none_or(|seen| seen.agree || seen.wall_ms > CHEAP_MS) || stop() {
                break;
            }
            seen = paired(subject.draw(frames)?);
        }
        agree &= seen.is_some_and(|seen| seen.agree);
        let disagreement = seen.map(|seen| seen.relative);
        Ok(Samples { frames, disagreement, ..Samples::default() })
    };
    let samples = subjects.iter_mut().zip(lengths);
    let samples = samples.map(|(subject, once)| warm(&mut **subject, once?)).collect();
    (if agree { Timing::Stamps } else { Timing::Wall }, samples)
}

/// The times of the same frames by both clocks.
#[derive(Clone, Copy)]
struct Paired {
    wall_ms: f64,
    relative: f64,
    agree: bool,
}

/// `None` without time stamps.
fn paired(drawn: Drawn) -> Option<Paired> {
    let wall_ms = ms(drawn.wall);
    let apart = (ms(drawn.stamps?) - wall_ms).abs();
    let agree = apart <= (AGREEMENT * wall_ms).max(SUBMISSION_MS);
    Some(Paired { wall_ms, relative: apart / wall_ms.max(1e-6), agree })
}

/// Estimates the time of a frame, in ms. The first frame may be slow: if frames are cheap, later ones are measured.
fn length(subject: &mut dyn Executor, stop: &dyn Fn() -> bool) -> Result<f64> {
    if stop() {
        return Ok(0.0);
    }
    let first = ms(subject.draw(1)?.wall);
    if first < ROUND_MS { Ok(ms(subject.draw(2)?.wall) / 2.0) } else { Ok(first) }
}

/// The subjects of the next round; empty if all are measured well enough.
fn active(samples: &[Result<Samples>], round: usize, rules: &Rules) -> Vec<usize> {
    let baseline = samples.first().and_then(|first| first.as_ref().ok());
    let wanting = |(index, sample): (usize, &Result<Samples>)| {
        let sample = sample.as_ref().ok()?;
        let values = match baseline {
            Some(baseline) if index > 0 => ratios(baseline, sample),
            _ => sample.time_ms.clone(),
        };
        let width = stats::interval(&values).zip(median(&values));
        let width =
            width.map_or(f64::INFINITY, |(interval, value)| relative_width(value, interval));
        (round < rules.min_rounds || width > rules.precision).then_some(index)
    };
    let mut wanted: Vec<usize> =
        samples.iter().enumerate().skip(1).filter_map(|(i, s)| wanting((i, s))).collect();
    // if the baseline is alone, its own interval counts
    let alone = samples.iter().skip(1).all(Result::is_err);
    if baseline.is_some() && (!wanted.is_empty() || (alone && wanting((0, &samples[0])).is_some()))
    {
        wanted.insert(0, 0);
    }
    wanted
}

/// The order of a round. Each round starts with another subject, and every second round runs backwards, so that no subject
/// always follows the same one.
fn order(active: &[usize], round: usize) -> Vec<usize> {
    let mut order = active.to_vec();
    order.rotate_left((round / 2) % active.len().max(1));
    if round % 2 == 1 {
        order.reverse();
    }
    order
}

#[cfg(test)]
mod tests;

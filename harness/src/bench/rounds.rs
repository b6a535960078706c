//! Interleaved rounds: every subject of a group is drawn once in each, so that whatever slows the machine down slows all
//! of them, and only ratios of the same round are formed.

use std::time::Duration;

use diffraction_shaders::error::Result;

use super::clock::{Clock, ms};
use super::stats::{self, MIN_VALUES, median, relative_width};

/// Something that draws frames and says how long they took.
pub trait Executor {
    /// Draws `frames` frames one after another.
    fn draw(&mut self, frames: usize) -> Result<Drawn>;
}

/// How long some frames took together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drawn {
    /// From submission until the driver says that they are done.
    pub wall: Duration,
    /// Between the driver's time stamps; none where it has none.
    pub stamps: Option<Duration>,
}

/// When enough was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Half of the width of the ratio's confidence interval over the ratio, that is aimed at.
    pub precision: f64,
    /// Time for each subject, warm-up not included; a round that began is finished.
    pub budget: Duration,
    /// Fewest rounds, whatever they cost.
    pub min_rounds: usize,
    /// Most rounds, whatever the precision.
    pub max_rounds: usize,
}

impl Rules {
    /// 2 %, in 6 to 60 rounds.
    pub fn standard(budget: Duration) -> Rules {
        Rules { precision: 0.02, budget, min_rounds: MIN_VALUES, max_rounds: 60 }
    }
}

/// Which clock the times of a group are of; one for all, so that ratios mean something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timing {
    /// Time stamps of the driver, which agreed with the wall for every subject.
    Stamps,
    /// From submission to the end, as the processor sees it.
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

/// What was measured of one subject, times for one frame in ms.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// Frames of a round.
    pub frames: usize,
    /// The round of each value below.
    pub rounds: Vec<usize>,
    /// Time by the group's clock.
    pub time_ms: Vec<f64>,
    /// Time of the processor, all threads.
    pub cpu_ms: Vec<f64>,
    /// `|time stamps / wall - 1|` while warming up; none where there are no time stamps.
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

/// In a round, a subject is drawn for this long at least, ms: frames of 2 ms twenty times …
const ROUND_MS: f64 = 40.0;
/// … and for this share of the longest frame: a short glance meets the machine busy or idle, a long one both.
const MIN_SHARE: f64 = 0.25;
/// … but no more frames than these.
const MAX_FRAMES: f64 = 20.0;
/// Time stamps that differ by more from the wall are not believed …
const AGREEMENT: f64 = 0.05;
/// … unless it is by less than what a submission costs, ms.
const SUBMISSION_MS: f64 = 0.5;
/// Other work may come between the last stamp and the wall's: short draws, ms, are compared again before that counts.
const CHEAP_MS: f64 = 500.0;
const RETRIES: usize = 2;

/// Measures a group. The first subject is what ratios are formed with: it is drawn as long as any other still is.
///
/// Each subject is drawn once to learn how long it takes, and once more to warm up and to compare clocks. A frame below
/// 40 ms, or much shorter than the longest, is then drawn several times in a round, one below 2 ms twenty times. The order within a round changes from round
/// to round. A subject leaves when the interval of its ratio is narrow enough; one that fails leaves with its error.
/// `stop` is asked before every draw, and what whole rounds have measured is kept. `progress` is told the share of the
/// time allowed that is spent.
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

/// Values of `baseline` over those of `other`, round by round.
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
        // a clock that is too coarse must not make a ratio infinite
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

/// What the two clocks say of the same frames.
#[derive(Clone, Copy)]
struct Paired {
    wall_ms: f64,
    relative: f64,
    agree: bool,
}

/// None where there are no stamps.
fn paired(drawn: Drawn) -> Option<Paired> {
    let wall_ms = ms(drawn.wall);
    let apart = (ms(drawn.stamps?) - wall_ms).abs();
    let agree = apart <= (AGREEMENT * wall_ms).max(SUBMISSION_MS);
    Some(Paired { wall_ms, relative: apart / wall_ms.max(1e-6), agree })
}

/// How long a frame takes, ms. A first frame may be slow: where frames are cheap, later ones are asked.
fn length(subject: &mut dyn Executor, stop: &dyn Fn() -> bool) -> Result<f64> {
    if stop() {
        return Ok(0.0);
    }
    let first = ms(subject.draw(1)?.wall);
    if first < ROUND_MS { Ok(ms(subject.draw(2)?.wall) / 2.0) } else { Ok(first) }
}

/// Subjects of the next round; empty when nothing is left to learn.
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
    // alone it has to be precise by itself
    let alone = samples.iter().skip(1).all(Result::is_err);
    if baseline.is_some() && (!wanted.is_empty() || (alone && wanting((0, &samples[0])).is_some()))
    {
        wanted.insert(0, 0);
    }
    wanted
}

/// Starts elsewhere in each round, and every other round runs backwards: nobody always follows the same one.
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

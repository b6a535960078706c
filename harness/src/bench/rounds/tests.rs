//! All tests here run on a mock clock that only scripted frames move.

use std::cell::Cell;

use diffraction_shaders::error::Error;

use super::*;

/// A clock that stands still between frames.
#[derive(Default)]
struct Mock(Cell<f64>);

impl Clock for Mock {
    fn wall(&self) -> Duration {
        Duration::from_secs_f64(self.0.get() * 1e-3)
    }

    /// As if two threads worked.
    fn cpu(&self) -> Duration {
        2 * self.wall()
    }
}

/// Ratio of a driver's stamps to the wall clock, by the number of the draw.
type Stamps = fn(usize) -> f64;

/// A frame whose time in ms is given by `script` from the number of the draw and the current time.
struct Scripted<'a, F> {
    clock: &'a Mock,
    draws: Cell<usize>,
    frames: &'a Cell<usize>,
    stamps: Option<Stamps>,
    script: F,
}

impl<F: Fn(usize, f64) -> Option<f64>> Executor for Scripted<'_, F> {
    fn draw(&mut self, frames: usize) -> Result<Drawn> {
        let draw = self.draws.replace(self.draws.get() + 1);
        self.frames.set(self.frames.get() + frames);
        let Some(once) = (self.script)(draw, self.clock.0.get()) else {
            return Err(Error::new("scripted", "the device was lost"));
        };
        let took = once * frames as f64;
        self.clock.0.set(self.clock.0.get() + took);
        let time = |ms: f64| Duration::from_secs_f64(ms * 1e-3);
        Ok(Drawn { wall: time(took), stamps: self.stamps.map(|factor| time(factor(draw) * took)) })
    }
}

/// Measures two scripts. Also returns the number of frames that each drew.
fn pair<A, B>(a: A, b: B, stamps: Option<Stamps>, rules: &Rules) -> (Measured, [usize; 2])
where
    A: Fn(usize, f64) -> Option<f64>,
    B: Fn(usize, f64) -> Option<f64>,
{
    let clock = Mock::default();
    let frames = [Cell::new(0), Cell::new(0)];
    let draws = Cell::new(0);
    let mut subjects: Vec<Box<dyn Executor + '_>> = vec![
        Box::new(Scripted {
            clock: &clock,
            draws: draws.clone(),
            frames: &frames[0],
            stamps,
            script: a,
        }),
        Box::new(Scripted { clock: &clock, draws, frames: &frames[1], stamps, script: b }),
    ];
    let measured = measure(&mut subjects, &clock, rules, &|_| (), &|| false);
    drop(subjects);
    (measured, frames.map(|cell| cell.get()))
}

/// Strict rules below have a negative precision: no interval is narrow enough.
fn rules(seconds: u64) -> Rules {
    Rules::standard(Duration::from_secs(seconds))
}

fn ok(measured: &Measured, index: usize) -> &Samples {
    measured.samples[index].as_ref().expect("measured")
}

#[test]
fn a_machine_that_slows_down_changes_times_and_not_ratios() {
    // four times slower after ten seconds
    let drift = |t: f64| 1.0 + 3.0 * (t / 10_000.0).min(1.0);
    let strict = Rules { precision: -1.0, ..rules(10) };
    let (measured, _) =
        pair(|_, t| Some(300.0 * drift(t)), |_, t| Some(100.0 * drift(t)), None, &strict);
    let ratios = ratios(ok(&measured, 0), ok(&measured, 1));
    let ratio = median(&ratios).expect("rounds");
    assert!((ratio - 3.0).abs() < 0.05, "{ratio}");
    let times = &ok(&measured, 1).time_ms;
    assert!(times[times.len() - 1] > 2.0 * times[0], "the drift is there: {times:?}");
}

#[test]
fn one_slow_round_in_seven_is_an_outlier_and_moves_nothing() {
    let strict = Rules { precision: -1.0, ..rules(20) };
    let hit = |draw: usize, _: f64| Some(if draw % 7 == 6 { 900.0 } else { 100.0 });
    let (measured, _) = pair(|_, _| Some(250.0), hit, None, &strict);
    let samples = ok(&measured, 1);
    let summary = stats::summary(&samples.time_ms).expect("rounds");
    assert_eq!((summary.median, summary.mad, summary.interval), (100.0, 0.0, [100.0, 100.0]));
    let expected = samples.time_ms.iter().filter(|time| **time > 100.0).count();
    assert!(expected > 1 && summary.outliers == expected, "{summary:?}");
    assert_eq!(median(&ratios(ok(&measured, 0), samples)), Some(2.5));
    assert_eq!(samples.cpu_ms[0], 200.0);
}

#[test]
fn a_slow_first_frame_counts_neither_as_time_nor_as_length() {
    let first = |draw: usize, _: f64| Some(if draw == 0 { 30.0 } else { 0.5 });
    let (measured, _) = pair(|_, _| Some(60.0), first, None, &rules(10));
    let samples = ok(&measured, 1);
    assert_eq!(samples.frames, 20, "twenty frames of what is below 2 ms");
    assert!(samples.time_ms.iter().all(|time| (time - 0.5).abs() < 1e-6), "{:?}", samples.time_ms);
    assert_eq!(ok(&measured, 0).frames, 1);
    // a quarter of the longest: 400 ms in frames of 150
    let (measured, _) = pair(|_, _| Some(1600.0), |_, _| Some(150.0), None, &rules(0));
    assert_eq!((ok(&measured, 0).frames, ok(&measured, 1).frames), (1, 3));
}

#[test]
fn rounds_go_on_until_the_interval_is_narrow_or_the_time_is_spent() {
    // steady: the minimum number of rounds suffices
    let (measured, frames) = pair(|_, _| Some(100.0), |_, _| Some(50.0), None, &rules(1000));
    assert_eq!(ok(&measured, 1).rounds, (0..MIN_VALUES).collect::<Vec<_>>());
    assert_eq!(frames, [MIN_VALUES + 2; 2], "two frames to warm up");
    // noise of 10 %, different in each round: more are needed
    let noisy = |draw: usize, _: f64| Some(50.0 * (1.0 + 0.1 * ((draw * 7) % 11) as f64 / 11.0));
    let (measured, _) = pair(|_, _| Some(100.0), noisy, None, &rules(1000));
    let rounds = ok(&measured, 1).rounds.len();
    assert!(rounds > MIN_VALUES, "{rounds}");
    // the same with 3 s for each: 3 s for both are 6 s, and a round takes about 0.15 s
    let strict = Rules { precision: -1.0, max_rounds: 1000, ..rules(3) };
    let (measured, _) = pair(|_, _| Some(100.0), noisy, None, &strict);
    assert!((38..=41).contains(&ok(&measured, 1).rounds.len()), "{:?}", ok(&measured, 1).rounds);
    // no budget, but still the minimum number of rounds
    let (measured, _) = pair(|_, _| Some(100.0), noisy, None, &rules(0));
    assert_eq!(ok(&measured, 1).rounds.len(), MIN_VALUES);
}

#[test]
fn stamps_are_believed_only_where_they_agree() {
    let cases: [(Option<Stamps>, Timing, f64); 6] = [
        (Some(|_| 1.0), Timing::Stamps, 1.0),
        (Some(|_| 0.97), Timing::Stamps, 0.97),
        // other work came between the stamps and the wall, once
        (Some(|draw| if draw == 1 { 0.5 } else { 1.0 }), Timing::Stamps, 1.0),
        // a driver that invents its time stamps
        (Some(|_| 0.0002), Timing::Wall, 1.0),
        (Some(|_| 1.2), Timing::Wall, 1.0),
        (None, Timing::Wall, 1.0),
    ];
    for (index, (stamps, timing, believed)) in cases.into_iter().enumerate() {
        let (measured, _) = pair(|_, _| Some(100.0), |_, _| Some(50.0), stamps, &rules(10));
        assert_eq!(measured.timing, timing, "case {index}");
        let time = ok(&measured, 0).time_ms[0];
        assert!((time - 100.0 * believed).abs() < 1e-3, "case {index}: {time}");
    }
}

#[test]
fn what_fails_leaves_and_the_rest_goes_on() {
    let lost = |draw: usize, _: f64| (draw < 4).then_some(50.0);
    let (measured, _) = pair(|_, _| Some(100.0), lost, None, &rules(10));
    let error = measured.samples[1].as_ref().expect_err("lost").to_string();
    assert!(error.contains("the device was lost"), "{error}");
    assert_eq!(ok(&measured, 0).rounds.len(), MIN_VALUES);
    // without its baseline a variant is measured alone
    let (measured, _) = pair(|_, _| None, |_, _| Some(50.0), None, &rules(10));
    assert!(measured.samples[0].is_err());
    assert_eq!(ok(&measured, 1).rounds.len(), MIN_VALUES);
    assert_eq!(ratios(&Samples::default(), ok(&measured, 1)), [0.0; 0]);
}

#[test]
fn an_interrupt_keeps_the_rounds_before_it() {
    let clock = Mock::default();
    let frames = Cell::new(0);
    let script = |_: usize, _: f64| Some(100.0);
    let subject =
        Scripted { clock: &clock, draws: Cell::new(0), frames: &frames, stamps: None, script };
    let mut subjects: Vec<Box<dyn Executor + '_>> = vec![Box::new(subject)];
    let measured = measure(&mut subjects, &clock, &rules(10), &|_| (), &|| frames.get() >= 4);
    assert_eq!(ok(&measured, 0).rounds, [0, 1], "after two frames to warm up");
}

#[test]
fn nobody_always_follows_the_same_one() {
    let orders: Vec<Vec<usize>> = (0..6).map(|round| order(&[0, 1, 2], round)).collect();
    for place in 0..3 {
        let mut seen: Vec<usize> = orders.iter().map(|order| order[place]).collect();
        seen.sort_unstable();
        assert_eq!(seen, [0, 0, 1, 1, 2, 2], "place {place} of {orders:?}");
    }
    assert!(order(&[], 3).is_empty());
}

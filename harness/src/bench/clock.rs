//! The wall clock and the processor's clock.

use std::time::{Duration, Instant};

/// A source of times.
pub trait Clock {
    /// Wall time since a fixed moment. It never runs backwards.
    fn wall(&self) -> Duration;

    /// Processor time of all threads of this process; zero if the system does not report it.
    fn cpu(&self) -> Duration;
}

/// The clocks of this machine.
#[derive(Clone, Copy, Debug)]
pub struct SystemClock(Instant);

impl SystemClock {
    /// Clocks that start now.
    pub fn new() -> SystemClock {
        SystemClock(Instant::now())
    }
}

impl Default for SystemClock {
    fn default() -> SystemClock {
        SystemClock::new()
    }
}

impl Clock for SystemClock {
    fn wall(&self) -> Duration {
        self.0.elapsed()
    }

    #[cfg(unix)]
    fn cpu(&self) -> Duration {
        use rustix::time::{ClockId, clock_gettime};
        // the system's times are never negative
        clock_gettime(ClockId::ProcessCPUTime).try_into().unwrap_or_default()
    }

    #[cfg(not(unix))]
    fn cpu(&self) -> Duration {
        Duration::ZERO
    }
}

/// A time in milliseconds.
pub fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clocks_do_not_go_back() {
        let clock = SystemClock::new();
        let (wall, cpu) = (clock.wall(), clock.cpu());
        let sum: f64 = (0..1_000_000).map(f64::from).map(f64::sqrt).sum();
        assert!(sum > 0.0 && clock.wall() >= wall && clock.cpu() >= cpu);
        assert_eq!(ms(Duration::from_micros(1500)), 1.5);
    }
}

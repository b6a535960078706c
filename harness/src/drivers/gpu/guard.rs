//! The open device, and guards around every call to it, which turn all failures into an `Error`.

use std::{
    any::Any,
    fmt::Write as _,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use diffraction_shaders::error::{Error, Result};

use super::backend::AdapterInfo;

/// A device with its queue, shared by its pipelines.
#[derive(Debug)]
pub(super) struct Shared {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    pub(super) info: AdapterInfo,
    pub(super) limits: wgpu::Limits,
    faults: Arc<Mutex<Faults>>,
    /// Calls take turns: wgpu's GL waits at most six seconds for its context, then panics, and a frame of another thread may be longer.
    turn: Mutex<()>,
    _instance: wgpu::Instance,
}

#[derive(Debug, Default)]
struct Faults {
    /// The first error of the running call.
    reported: Option<String>,
    /// Why no further call can succeed.
    lost: Option<String>,
}

impl Shared {
    pub(super) fn new(
        instance: wgpu::Instance,
        device: wgpu::Device,
        queue: wgpu::Queue,
        info: AdapterInfo,
        limits: wgpu::Limits,
    ) -> Shared {
        let faults = Arc::new(Mutex::new(Faults::default()));
        let reported = Arc::clone(&faults);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            lock(&reported).reported.get_or_insert_with(|| message(&error));
        }));
        let lost = Arc::clone(&faults);
        device.set_device_lost_callback(move |reason, text| {
            lock(&lost).lost.get_or_insert_with(|| format!("{reason:?} {text}").to_lowercase());
        });
        Shared { device, queue, info, limits, faults, turn: Mutex::new(()), _instance: instance }
    }

    /// Runs `work`, alone on this device. Reports a lost device first, then an error of wgpu, then the result of `work`.
    pub(super) fn guarded<T>(&self, subject: &str, work: impl FnOnce() -> Result<T>) -> Result<T> {
        let _turn = lock(&self.turn);
        self.intact(subject)?;
        lock(&self.faults).reported = None;
        let work = || {
            let result = work();
            // wgpu reports a lost device only through the callback, at the next poll
            self.device.poll(wgpu::PollType::Poll).ok();
            result
        };
        let result = match catch_unwind(AssertUnwindSafe(work)) {
            Ok(result) => result,
            Err(panic) => {
                let text = payload(panic.as_ref());
                lock(&self.faults).lost.get_or_insert_with(|| text.clone());
                return Err(Error::new(subject, text));
            }
        };
        self.intact(subject)?;
        let reported = lock(&self.faults).reported.take();
        match reported {
            Some(text) => Err(Error::new(subject, text)),
            None => result,
        }
    }

    /// Waits for a submission, without a time limit.
    pub(super) fn wait(&self, subject: &str, submission: &wgpu::SubmissionIndex) -> Result<()> {
        /// Maximum number of immediate timeouts in a row: GL reports a failed wait as a timeout.
        const REFUSALS: u32 = 1000;
        let mut refused = 0;
        while refused < REFUSALS {
            let begun = Instant::now();
            let outcome = self.device.poll(wgpu::PollType::Wait {
                submission_index: Some(submission.clone()),
                timeout: Some(Duration::from_secs(1)),
            });
            match outcome {
                Ok(_) => return Ok(()),
                Err(wgpu::PollError::Timeout) => self.intact(subject)?,
                Err(e) => return Err(Error::new(subject, "cannot wait").source(e)),
            }
            refused = if begun.elapsed() < Duration::from_millis(10) { refused + 1 } else { 0 };
        }
        Err(Error::new(subject, "the driver refuses to wait for the frame"))
    }

    fn intact(&self, subject: &str) -> Result<()> {
        match &lock(&self.faults).lost {
            Some(why) => {
                Err(Error::new(subject, format!("the device of {} was lost: {why}", self.info))
                    .remedy("open the device again"))
            }
            None => Ok(()),
        }
    }
}

/// Runs `work` and turns a panic of wgpu into an error.
pub(super) fn caught<T>(subject: &str, work: impl FnOnce() -> Result<T>) -> Result<T> {
    catch_unwind(AssertUnwindSafe(work))
        .unwrap_or_else(|panic| Err(Error::new(subject, payload(panic.as_ref()))))
}

/// The lock, also after a panic of a holder: nothing here is left half-changed.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn payload(panic: &(dyn Any + Send)) -> String {
    let text = panic
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("without a message");
    format!("wgpu panicked: {}", text.trim())
}

/// wgpu's text without its heading and empty lines. Out of memory has no text: then the chain of causes.
fn message(error: &wgpu::Error) -> String {
    let text = error.to_string();
    let body = text.split_once("Caused by:").map_or(text.as_str(), |(_, body)| body).trim();
    let lines: Vec<&str> = body.lines().filter(|line| !line.trim().is_empty()).collect();
    let mut body = lines.join("\n");
    if let wgpu::Error::OutOfMemory { source } = error {
        body = format!("out of memory: {source}");
        let mut cause = source.source();
        while let Some(inner) = cause {
            // writing to a string cannot fail
            let _ = write!(body, ": {inner}");
            cause = inner.source();
        }
    }
    body
}

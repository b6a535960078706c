//! Giving up from another thread, in order.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::error::{Error, Result};

/// Cancels a write from another thread. The previous output stays complete.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<(Mutex<State>, Condvar)>);

#[derive(Debug, Default)]
struct State {
    cancelled: bool,
    writing: bool,
    /// Folders that were made for the output, the innermost first.
    created: Vec<PathBuf>,
}

impl Cancel {
    /// A new handle, not cancelled.
    pub fn new() -> Cancel {
        Cancel::default()
    }

    /// Cancels. When it returns, the new output has either come or will not come.
    pub fn cancel(&self) {
        self.state().cancelled = true;
    }

    /// Whether it was cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.state().cancelled
    }

    /// After [`Cancel::cancel`]: waits until the write under way has removed what it made, at most for `limit`. So the
    /// process may end.
    pub fn settle(&self, limit: Duration) {
        let (_, ended) = &*self.0;
        let waited = ended.wait_timeout_while(self.state(), limit, |state| state.writing);
        let (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        // only empty folders can be removed like this
        state.created.iter().for_each(|folder| drop(std::fs::remove_dir(folder)));
    }

    /// Notes folders that were made for the output. They go if nothing comes into them.
    pub(super) fn created(&self, folders: &[PathBuf]) {
        self.state().created = folders.to_vec();
    }

    /// Begins a write, unless cancelled.
    pub(super) fn begin(&self, out: &Path) -> Result<Writing<'_>> {
        self.unless(out, || Ok(()))?;
        self.state().writing = true;
        Ok(Writing(self))
    }

    /// Does what must not be interrupted, unless cancelled before.
    pub(super) fn unless<T>(&self, out: &Path, act: impl FnOnce() -> Result<T>) -> Result<T> {
        let state = self.state();
        if state.cancelled {
            let cause = "the run was interrupted; nothing was changed";
            return Err(Error::new(format!("output {}", out.display()), cause));
        }
        act()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A write under way.
pub(super) struct Writing<'a>(&'a Cancel);

impl Drop for Writing<'_> {
    fn drop(&mut self) {
        self.0.state().writing = false;
        self.0.0.1.notify_all();
    }
}

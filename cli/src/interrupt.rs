//! Signals. An interrupt or a termination ends every command within a second. It leaves the previous output whole, no temporary
//! folder, and no program that the command started. A full disk is an error.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, LazyLock, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use anyhow::{Context, Result};
use diffraction_shaders::package::Cancel;
use tempfile::TempDir;

/// Exit code of an interrupted command, as shells have it.
const INTERRUPTED: i32 = 130;

/// How long a command that asked for [`flag`] may take to end in order.
const GRACE: Duration = Duration::from_millis(350);

/// How long a write may take to notice that it is cancelled and to remove what it made.
const SETTLE: Duration = Duration::from_secs(10);

type Action = Box<dyn FnOnce() + Send>;

/// What is to be done before an interrupted process ends, by the order in which it was asked for.
static ACTIONS: Mutex<BTreeMap<u64, Action>> = Mutex::new(BTreeMap::new());
static NEXT: AtomicU64 = AtomicU64::new(0);
static CANCEL: OnceLock<Cancel> = OnceLock::new();
/// Set by an interrupt.
static FLAG: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
/// Whether the command looks at the flag and ends by itself.
static IS_ORDERLY: AtomicBool = AtomicBool::new(false);

/// Handles interrupts and terminations from now on. Every command calls this first.
pub fn watch() -> Result<()> {
    static WATCHED: Mutex<bool> = Mutex::new(false);
    let mut is_watched = WATCHED.lock().unwrap_or_else(PoisonError::into_inner);
    if !*is_watched {
        ctrlc::set_handler(stop).context("signals cannot be handled")?;
        *is_watched = true;
    }
    Ok(())
}

/// Ends this process as an interrupt does.
pub fn stop() {
    FLAG.store(true, Ordering::Relaxed);
    if IS_ORDERLY.load(Ordering::Relaxed) {
        std::thread::sleep(GRACE);
    }
    exit()
}

/// Ends the command once it has seen that it was interrupted: first what [`before_exit`] was given, then the process. Nothing else
/// runs, since threads of drivers may stand anywhere.
pub fn exit() -> ! {
    // held to the end, so that another thread which comes here does not end the process too early
    let mut actions = ACTIONS.lock().unwrap_or_else(PoisonError::into_inner);
    // the last one first: a program that was started ends before the folder that it writes to goes
    for (_, action) in std::mem::take(&mut *actions).into_iter().rev() {
        action();
    }
    #[cfg(unix)]
    signal_hook::low_level::exit(INTERRUPTED);
    #[cfg(not(unix))]
    std::process::exit(INTERRUPTED)
}

/// An action that an interrupt runs as long as this value lives.
#[must_use = "dropped, it takes the action back"]
#[derive(Debug)]
pub struct BeforeExit(u64);

impl Drop for BeforeExit {
    fn drop(&mut self) {
        ACTIONS.lock().unwrap_or_else(PoisonError::into_inner).remove(&self.0);
    }
}

/// Has an interrupt run an action before it ends the process: end a program that was started, remove what is unfinished. The action
/// must be quick.
pub fn before_exit(action: impl FnOnce() + Send + 'static) -> BeforeExit {
    let id = NEXT.fetch_add(1, Ordering::Relaxed);
    ACTIONS.lock().unwrap_or_else(PoisonError::into_inner).insert(id, Box::new(action));
    BeforeExit(id)
}

/// A temporary folder that an interrupt removes, too.
#[derive(Debug)]
pub struct TemporaryFolder {
    folder: TempDir,
    _removed: BeforeExit,
}

impl TemporaryFolder {
    /// Makes one in the system's folder of temporary files.
    pub fn new() -> std::io::Result<TemporaryFolder> {
        TempDir::new().map(TemporaryFolder::of)
    }

    /// Takes over a folder.
    pub fn of(folder: TempDir) -> TemporaryFolder {
        let path = folder.path().to_owned();
        let removed = before_exit(move || {
            let _ = fs::remove_dir_all(path);
        });
        TemporaryFolder { folder, _removed: removed }
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// On an interrupt or a termination: cancels, and waits until the write under way has removed what it made.
pub fn install() -> Result<Cancel> {
    if let Some(cancel) = CANCEL.get() {
        return Ok(cancel.clone());
    }
    let cancel = CANCEL.get_or_init(Cancel::new);
    let stopped = cancel.clone();
    let action = before_exit(move || {
        stopped.cancel();
        stopped.settle(SETTLE);
    });
    // to the end of the process
    std::mem::forget(action);
    watch()?;
    Ok(cancel.clone())
}

/// On an interrupt or a termination: sets the flag, so that work in progress ends in order. What takes longer than a third of a second is
/// cut off. For commands that write only whole lines or whole files.
pub fn flag() -> Result<Arc<AtomicBool>> {
    IS_ORDERLY.store(true, Ordering::Relaxed);
    watch()?;
    Ok(Arc::clone(&FLAG))
}

/// Makes a write beyond the file size limit return an error instead of killing the process.
pub fn full_disk_is_an_error() -> Result<()> {
    #[cfg(unix)]
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::<AtomicBool>::default())
        .context("signals cannot be handled")?;
    Ok(())
}

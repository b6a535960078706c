//! Signals. An interrupt leaves the previous output whole and no temporary folder. A full disk is an error.

use std::sync::{
    Arc, OnceLock,
    atomic::{AtomicBool, Ordering},
};
use std::time::Duration;

use anyhow::{Context, Result};
use diffraction_shaders::package::Cancel;

/// Exit code of an interrupted command, as shells have it.
const INTERRUPTED: i32 = 130;

static CANCEL: OnceLock<Cancel> = OnceLock::new();

/// On an interrupt or a termination: cancels, waits until the write under way has removed what it made, and exits.
pub fn install() -> Result<Cancel> {
    let mut is_new = false;
    let cancel = CANCEL.get_or_init(|| {
        is_new = true;
        Cancel::new()
    });
    if is_new {
        let cancel = cancel.clone();
        let stop = move || {
            cancel.cancel();
            cancel.settle(Duration::from_secs(10));
            std::process::exit(INTERRUPTED);
        };
        ctrlc::set_handler(stop).context("signals cannot be handled")?;
    }
    Ok(cancel.clone())
}

/// On an interrupt or a termination: sets the flag, so that work in progress ends in order. On the second one: exits. For
/// commands that write only whole lines or whole files.
pub fn flag() -> Result<Arc<AtomicBool>> {
    let flag = Arc::<AtomicBool>::default();
    let set = Arc::clone(&flag);
    let stop = move || {
        if set.swap(true, Ordering::Relaxed) {
            std::process::exit(INTERRUPTED);
        }
    };
    ctrlc::set_handler(stop).context("signals cannot be handled")?;
    Ok(flag)
}

/// Ends the command once it has seen that it was interrupted.
pub fn exit() -> ! {
    std::process::exit(INTERRUPTED)
}

/// Makes a write beyond the file size limit return an error instead of killing the process.
pub fn full_disk_is_an_error() -> Result<()> {
    #[cfg(unix)]
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::<AtomicBool>::default())
        .context("signals cannot be handled")?;
    Ok(())
}

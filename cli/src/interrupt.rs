//! Signals. An interrupt leaves the previous output whole and no temporary folder. A full disk is an error.

use std::fs;
use std::path::Path;
use std::sync::{
    Arc, OnceLock,
    atomic::{AtomicBool, Ordering},
};
use std::time::Duration;

use anyhow::{Context, Result};
use diffraction_shaders::package::{Cancel, temporary_folder};

/// Exit code of an interrupted command, as shells have it.
const INTERRUPTED: i32 = 130;

static CANCEL: OnceLock<Cancel> = OnceLock::new();

/// On an interrupt or a termination: cancels the write, removes the temporary folder beside `out` and the folder `other`,
/// and exits.
pub fn install(out: &Path, other: Option<&Path>) -> Result<Cancel> {
    let mut is_new = false;
    let cancel = CANCEL.get_or_init(|| {
        is_new = true;
        Cancel::new()
    });
    if is_new {
        let (cancel, temporary) = (cancel.clone(), temporary_folder(out)?);
        let other = other.map(Path::to_owned);
        let stop = move || {
            cancel.cancel();
            // the writer may be in the middle of a file, and begin another before it sees the flag
            for _ in 0..50 {
                if !temporary.exists() || fs::remove_dir_all(&temporary).is_ok() {
                    break;
                }
                std::thread::sleep(Duration::from_millis(10));
            }
            if let Some(other) = &other {
                let _ = fs::remove_dir_all(other);
            }
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

//! The browser's program: finds it, starts it with a profile of its own, and ends it with all its processes.

use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use diffraction_shaders::error::{Error, Result};

use diffraction_cli::interrupt::BeforeExit;

use crate::process::{Guard, ended_with_us};

use super::failure::failure;
use super::user_folder::UserFolder;

/// Names under which distributions install Chromium.
const PROGRAMS: [&str; 4] =
    ["chromium", "chromium-browser", "google-chrome-stable", "google-chrome"];

/// How to install it.
const REMEDY: &str = "install it: apt-get install chromium";

/// The file in the profile for the program's stderr.
const LOG: &str = "stderr.log";

/// Maximum length of the browser's own folder of temporary files. It makes a socket there, in a folder of its own; the name of a
/// socket has at most 107 bytes.
const MAX_TEMPORARY: usize = 60;

/// Flags for every machine.
const FLAGS: &[&str] = &[
    "--headless=new",
    // switch off the background services of a browser
    "--no-first-run",
    "--no-default-browser-check",
    "--no-proxy-server",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-extensions",
    "--disable-sync",
    "--disable-breakpad",
    "--password-store=basic",
    // containers have little shared memory
    "--disable-dev-shm-usage",
    // the watchdog would end drivers that draw for longer than ten seconds
    "--disable-gpu-watchdog",
    // otherwise a page gets no new context after a lost one
    "--disable-domain-blocking-for-3d-apis",
];

/// A running browser.
#[derive(Debug)]
pub(super) struct Chromium {
    child: Child,
    profile: UserFolder,
    _ended: BeforeExit,
    _guard: Guard,
}

impl Chromium {
    /// Starts `program`, or the first installed one of the usual names, on a page.
    pub(super) fn start(program: Option<&Path>, flags: &[&str], address: &str) -> Result<Chromium> {
        let profile = UserFolder::new()?;
        let usual = PROGRAMS.map(Path::new);
        for candidate in program.as_ref().map_or(usual.as_slice(), std::slice::from_ref) {
            match spawn(candidate, flags, address, profile.path()) {
                Ok(child) => {
                    let (ended, guard) = (ended_with_us(&child), Guard::of(&child));
                    return Ok(Chromium { child, profile, _ended: ended, _guard: guard });
                }
                Err(e) if e.kind() == io::ErrorKind::NotFound => {}
                Err(e) => {
                    let cause = format!("{} cannot be started", candidate.display());
                    return Err(failure(cause).source(e));
                }
            }
        }
        let cause = match program {
            Some(program) => format!("{} does not exist", program.display()),
            None => "the routes webgpu and webgl2 need Chromium, which is not installed".to_owned(),
        };
        Err(failure(cause).remedy(REMEDY))
    }

    /// How the program ended, if it did.
    pub(super) fn ended(&mut self) -> Option<Error> {
        match self.child.try_wait() {
            Ok(None) => None,
            Ok(Some(status)) => Some(failure(format!("ended with {status}{}", self.last_words()))),
            Err(e) => Some(failure("its process cannot be observed").source(e)),
        }
    }

    /// Waits for a successful end, and returns what the program wrote on stderr.
    pub(super) fn finish(mut self, limit: Duration) -> Result<String> {
        let begun = Instant::now();
        loop {
            match self.child.try_wait() {
                Ok(Some(status)) if status.success() => return Ok(self.said()),
                Ok(None) if begun.elapsed() > limit => {
                    let words = self.last_words();
                    return Err(failure(format!("did not end in {} s{words}", limit.as_secs())));
                }
                Ok(None) => std::thread::sleep(Duration::from_millis(20)),
                _ => {
                    return Err(self
                        .ended()
                        .unwrap_or_else(|| failure("its process cannot be observed")));
                }
            }
        }
    }

    /// What the program wrote on stderr.
    pub(super) fn said(&self) -> String {
        let log = fs::read(self.profile.path().join(LOG)).unwrap_or_default();
        String::from_utf8_lossy(&log).into_owned()
    }

    /// The last lines of stderr, to append to a message.
    pub(super) fn last_words(&self) -> String {
        const LINES: usize = 5;
        const LENGTH: usize = 300;
        let log = self.said();
        let lines = log.lines().filter(|line| !line.contains("dbus") && !line.trim().is_empty());
        let lines: Vec<String> =
            lines.map(|line| line.chars().take(LENGTH).collect::<String>()).collect();
        match &lines[lines.len().saturating_sub(LINES)..] {
            [] => String::new(),
            last => format!("; its last lines on stderr: {}", last.join(" | ")),
        }
    }

    /// The folder with the profile.
    pub(super) fn profile(&self) -> &Path {
        self.profile.path()
    }

    /// Id of the first process.
    pub(super) fn id(&self) -> u32 {
        self.child.id()
    }
}

impl Drop for Chromium {
    fn drop(&mut self) {
        end(&mut self.child);
        self.profile.remove();
    }
}

fn spawn(program: &Path, flags: &[&str], address: &str, profile: &Path) -> io::Result<Child> {
    let mut command = Command::new(program);
    command.args(FLAGS).args(flags);
    if is_root() {
        // the sandbox does not start as root
        command.arg("--no-sandbox");
    }
    let mut folder = std::ffi::OsString::from("--user-data-dir=");
    folder.push(profile);
    command.arg(folder).arg(address);
    // what the browser puts into the system's folder of temporary files would stay if it is killed
    let temporary = profile.join("tmp");
    if temporary.as_os_str().len() <= MAX_TEMPORARY {
        fs::create_dir_all(&temporary)?;
        command.env("TMPDIR", temporary);
    }
    let log = File::create(profile.join(LOG))?;
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(log);
    #[cfg(unix)]
    {
        use std::os::unix::process::CommandExt;
        // a process group of its own, so that all processes can be ended at once
        command.process_group(0);
    }
    command.spawn()
}

#[cfg(unix)]
fn is_root() -> bool {
    rustix::process::geteuid().is_root()
}

#[cfg(not(unix))]
fn is_root() -> bool {
    false
}

/// Ends the program and its process group, if it still runs.
fn end(child: &mut Child) {
    if matches!(child.try_wait(), Ok(None)) {
        #[cfg(unix)]
        {
            use rustix::process::{Pid, Signal, kill_process_group};
            let _ = kill_process_group(Pid::from_child(child), Signal::KILL);
        }
        let _ = child.kill();
        let _ = child.wait();
    }
}

//! Finds, runs and stops programs of this machine.

mod glslang;
mod guard;
mod output;
mod tools;
pub mod watched;

use std::{
    env, fmt, fs, io,
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    thread,
    time::{Duration, Instant},
};

use diffraction_cli::interrupt::{BeforeExit, before_exit};

pub use glslang::{GLSLANG, GLSLANG_PACKAGE, hlsl_options, hlsl_to_spirv};
pub use guard::Guard;
pub use output::KEPT;
pub use tools::tools_folder;

/// Interval between checks of a running tool.
const POLL: Duration = Duration::from_millis(2);
/// How long output is waited for after a tool has ended: what it left running may hold the stream open.
const LAST_WORDS: Duration = Duration::from_secs(1);

/// Why a program gave no good answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fault {
    /// It could not be started.
    NotStarted(String),
    /// It did not end in time.
    TimedOut(Duration),
    /// A signal ended it.
    Crashed(String),
    /// It ended with another exit code than 0. Its command line, exit code and output.
    Refused(String),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::TimedOut(limit) => write!(f, "did not end within {} s", limit.as_secs_f64()),
            Fault::NotStarted(text) | Fault::Crashed(text) | Fault::Refused(text) => {
                f.write_str(text)
            }
        }
    }
}

impl From<String> for Fault {
    fn from(text: String) -> Fault {
        Fault::Refused(text)
    }
}

/// The program of this name in the first folder of the PATH that has it.
pub fn on_path(name: &str) -> Option<PathBuf> {
    files_on_path(name).find(|file| is_executable(file))
}

/// A file of this name on the PATH that nobody may execute, where no program has the name.
pub fn not_executable(name: &str) -> Option<PathBuf> {
    if on_path(name).is_some() { None } else { files_on_path(name).next() }
}

fn files_on_path(name: &str) -> impl Iterator<Item = PathBuf> {
    let path = env::var_os("PATH").unwrap_or_default();
    let file = format!("{name}{}", env::consts::EXE_SUFFIX);
    let files: Vec<PathBuf> = env::split_paths(&path).map(|folder| folder.join(&file)).collect();
    files.into_iter().filter(|file| file.is_file())
}

#[cfg(unix)]
fn is_executable(file: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    fs::metadata(file).is_ok_and(|data| data.permissions().mode() & 0o111 != 0)
}

#[cfg(not(unix))]
fn is_executable(file: &Path) -> bool {
    fs::metadata(file).is_ok()
}

/// Runs a command and returns its exit status and its output, standard error first, of each stream the first [`KEPT`] bytes.
/// After the time limit the program and all that it started are ended.
pub fn run(command: &mut Command, limit: Duration) -> Result<(ExitStatus, String), Fault> {
    let command = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    #[cfg(unix)]
    {
        use std::os::unix::process::CommandExt;
        // a process group of its own, so that all its processes can be ended at once
        command.process_group(0);
    }
    let failed = |error: io::Error| Fault::NotStarted(format!("cannot be run: {error}"));
    let mut child = command.spawn().map_err(failed)?;
    let _ended = ended_with_us(&child);
    let streams = [child.stderr.take().map(output::keep), child.stdout.take().map(output::keep)];
    let end = Instant::now() + limit;
    let status = loop {
        if let Some(status) = child.try_wait().map_err(failed)? {
            break status;
        }
        if Instant::now() >= end {
            stop(&mut child);
            return Err(Fault::TimedOut(limit));
        }
        thread::sleep(POLL);
    };
    let last = Instant::now() + LAST_WORDS;
    let texts = streams.into_iter().flatten().map(|stream| stream.text(last));
    Ok((status, texts.collect()))
}

/// Runs a command whose last argument is a file. Returns its output, as a fault if it did not succeed.
pub fn accepted(command: &mut Command, limit: Duration) -> Result<String, Fault> {
    let (status, text) = run(command, limit)?;
    if status.success() {
        return Ok(text);
    }
    let program = Path::new(command.get_program()).file_name().unwrap_or_default();
    let mut words = vec![program.to_string_lossy().into_owned()];
    // the caller's message names the file
    let options = command.get_args().map(|argument| argument.to_string_lossy().into_owned());
    words.extend(options);
    words.pop();
    let text = format!("{}: {status}\n{}", words.join(" "), text.trim());
    Err(if status.code().is_none() { Fault::Crashed(text) } else { Fault::Refused(text) })
}

/// Runs a command to its end, without a time limit. Its output is not kept.
pub fn to_its_end(command: &mut Command) -> io::Result<ExitStatus> {
    #[cfg(unix)]
    {
        use std::os::unix::process::CommandExt;
        command.process_group(0);
    }
    let mut child = command.spawn()?;
    let _ended = ended_with_us(&child);
    child.wait()
}

/// Has an interrupt of this program end a program that leads a process group, with all of the group.
pub fn ended_with_us(child: &Child) -> BeforeExit {
    #[cfg(unix)]
    {
        use rustix::process::{Pid, Signal, kill_process_group};
        let group = Pid::from_child(child);
        before_exit(move || {
            let _ = kill_process_group(group, Signal::KILL);
        })
    }
    #[cfg(not(unix))]
    before_exit(|| ())
}

/// Ends a program with its process group.
fn stop(child: &mut Child) {
    #[cfg(unix)]
    {
        use rustix::process::{Pid, Signal, kill_process_group};
        let _ = kill_process_group(Pid::from_child(child), Signal::KILL);
    }
    let _ = child.kill();
    let _ = child.wait();
}

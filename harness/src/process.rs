//! Finds, runs and stops programs of this machine.

mod glslang;

use std::{
    env,
    io::{self, Read},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::mpsc::{Receiver, channel},
    thread,
    time::{Duration, Instant},
};

pub use glslang::{GLSLANG, GLSLANG_PACKAGE, hlsl_options, hlsl_to_spirv};

/// Interval between checks of a running tool.
const POLL: Duration = Duration::from_millis(2);

/// The program of this name in the first folder of the PATH that has it.
pub fn on_path(name: &str) -> Option<PathBuf> {
    let path = env::var_os("PATH")?;
    let programs = env::split_paths(&path)
        .map(|folder| folder.join(format!("{name}{}", env::consts::EXE_SUFFIX)));
    programs.into_iter().find(|program| program.is_file())
}

/// Runs a command and returns its exit status and all its output, standard error first. An error after the time limit.
pub fn run(command: &mut Command, limit: Duration) -> io::Result<(ExitStatus, String)> {
    let command = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn()?;
    let streams = [child.stderr.take().map(drain), child.stdout.take().map(drain)];
    let end = Instant::now() + limit;
    let status = wait(&mut child, end, limit)?;
    let mut text = String::new();
    for stream in streams.into_iter().flatten() {
        // a process that the tool left running may hold the stream open
        let left = end.saturating_duration_since(Instant::now());
        let bytes = stream.recv_timeout(left).unwrap_or_default();
        text.push_str(&String::from_utf8_lossy(&bytes));
    }
    Ok((status, text))
}

/// Runs a command whose last argument is a file. Returns its output, as an error if it did not succeed.
pub fn accepted(command: &mut Command, limit: Duration) -> Result<String, String> {
    let (status, text) = run(command, limit).map_err(|error| error.to_string())?;
    if status.success() {
        return Ok(text);
    }
    let program = Path::new(command.get_program()).file_name().unwrap_or_default();
    let mut words = vec![program.to_string_lossy().into_owned()];
    // the caller's message names the file
    let options = command.get_args().map(|argument| argument.to_string_lossy().into_owned());
    words.extend(options);
    words.pop();
    Err(format!("{}: {status}\n{}", words.join(" "), text.trim()))
}

/// Waits until the process ends, or kills it.
fn wait(child: &mut Child, end: Instant, limit: Duration) -> io::Result<ExitStatus> {
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        if Instant::now() >= end {
            child.kill()?;
            child.wait()?;
            let message = format!("did not end within {} s", limit.as_secs_f64());
            return Err(io::Error::new(io::ErrorKind::TimedOut, message));
        }
        thread::sleep(POLL);
    }
}

/// Reads a stream to its end on a thread of its own, so that neither stream can fill up.
fn drain(mut stream: impl Read + Send + 'static) -> Receiver<Vec<u8>> {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        let mut bytes = Vec::new();
        // on an error, what was read so far is still worth showing
        let _ = stream.read_to_end(&mut bytes);
        let _ = sender.send(bytes);
    });
    receiver
}

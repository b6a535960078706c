//! Replaces the running program by another one.

use std::process::Command;

/// Replaces this process by another program. Returns only if that program could not be started.
#[cfg(unix)]
pub fn by(mut command: Command) -> anyhow::Error {
    use std::os::unix::process::CommandExt;
    let error = command.exec();
    failure(&command, &error)
}

/// Runs another program and ends with its exit code. Returns only if that program could not be started.
#[cfg(not(unix))]
pub fn by(mut command: Command) -> anyhow::Error {
    match command.status() {
        Ok(status) => std::process::exit(status.code().unwrap_or(2)),
        Err(error) => failure(&command, &error),
    }
}

fn failure(command: &Command, error: &std::io::Error) -> anyhow::Error {
    anyhow::anyhow!("{} cannot be started: {error}", command.get_program().display())
}

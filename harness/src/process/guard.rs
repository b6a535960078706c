//! Ends a program once this process is gone, however it went.

use std::io::Write;
use std::process::{Child, Command, Stdio};

/// Waits for a line or for the end of its input, which comes when the process that holds the other end is gone.
const SCRIPT: &str = r#"read -r word; [ "$word" = done ] || kill -s KILL -- "-$1""#;

/// As long as it lives, a shell waits to end a program with its process group if this process is killed. A signal that cannot be
/// caught leaves no other way.
#[derive(Debug)]
pub struct Guard(Option<Child>);

impl Guard {
    /// Guards a program that leads a process group. Without a shell there is no guard.
    pub fn of(child: &Child) -> Guard {
        let mut command = Command::new("sh");
        command.args(["-c", SCRIPT, "sh"]).arg(child.id().to_string());
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
        #[cfg(unix)]
        {
            use std::os::unix::process::CommandExt;
            // what ends the group of this process must not end the shell
            command.process_group(0);
        }
        Guard(if cfg!(unix) { command.spawn().ok() } else { None })
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        if let Some(shell) = &mut self.0 {
            if let Some(mut input) = shell.stdin.take() {
                let _ = input.write_all(b"done\n");
            }
            let _ = shell.wait();
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::process::{CommandExt, ExitStatusExt};
    use std::time::Duration;

    use super::*;

    fn sleeper() -> Child {
        Command::new("sleep").arg("60").process_group(0).spawn().expect("sleep runs")
    }

    #[test]
    fn only_without_a_word_the_program_is_ended() {
        let mut child = sleeper();
        drop(Guard::of(&child));
        std::thread::sleep(Duration::from_millis(200));
        assert!(child.try_wait().expect("waits").is_none(), "it still runs");
        child.kill().expect("is killed");
        child.wait().expect("ends");

        let mut child = sleeper();
        let mut guard = Guard::of(&child);
        // what happens to the pipe when this process is killed
        drop(guard.0.as_mut().and_then(|shell| shell.stdin.take()));
        assert_eq!(child.wait().expect("ends").signal(), Some(9));
    }
}

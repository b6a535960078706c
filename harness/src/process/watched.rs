//! A command on drivers runs in a child process, which its parent watches: a driver that crashes takes only the child along.
//!
//! The child says what it is about to draw. If a signal ends it, the parent knows what was being drawn, and starts another child,
//! which goes on without the route that crashed. Both talk over the child's standard input, a pair of sockets:
//!
//! * the parent's first line is a [`History`]: what crashed, and what earlier children kept;
//! * each line of the child is a `Message`;
//! * the end of the stream tells the child that its parent is gone or was interrupted.

use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::Value;

#[cfg(unix)]
pub use unix::watch;

/// What is being done on a driver.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// The route: `KIND`, or `KIND:ADAPTER` once the adapter is known.
    pub route: String,
    /// The surface, if one is drawn.
    pub surface: Option<String>,
    /// The variant or variants that are drawn, if any are.
    pub variant: Option<String>,
    /// Direction towards the light, if only one is drawn: theta and phi in degrees.
    pub light: Option<[f64; 2]>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.surface, &self.variant) {
            (Some(surface), Some(variant)) => write!(f, "drawing {variant} on {surface}"),
            (Some(surface), None) => write!(f, "opening it for {surface}"),
            _ => write!(f, "opening it"),
        }
    }
}

/// A child that a driver took along.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Crash {
    /// What was being done.
    pub place: Place,
    /// How the process ended.
    pub how: String,
}

impl Crash {
    /// The reason for records and messages.
    pub fn reason(&self) -> String {
        format!(
            "the driver ended the process ({}) while {}; this route is not tried again",
            self.how, self.place
        )
    }

    /// Whether it takes a route out of the run. A crash while the adapters of a kind are listed takes all its adapters out.
    pub fn concerns(&self, route: &str) -> bool {
        let kind = |route: &str| route.split(':').next().unwrap_or_default().to_owned();
        let is_vulkan = |kind: &str| ["vulkan", "spirv", "hlsl"].contains(&kind);
        match self.place.route.contains(':') {
            true => self.place.route == route,
            // three kinds list the same adapters
            false => {
                let (own, other) = (kind(&self.place.route), kind(route));
                own == other || is_vulkan(&own) && is_vulkan(&other)
            }
        }
    }
}

/// What happened before a child began.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct History {
    /// The crashes so far.
    pub crashes: Vec<Crash>,
    /// What earlier children kept, in their order.
    pub kept: Vec<Value>,
}

impl History {
    /// Why a route is not tried, if it crashed.
    pub fn refusal(&self, route: &str) -> Option<String> {
        self.crashes.iter().find(|crash| crash.concerns(route)).map(Crash::reason)
    }
}

/// What a child says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Message {
    /// What it does from now on.
    Place(Place),
    /// What a later child needs.
    Keep(Value),
}

/// The child's side. Outside of a child, nothing is said and nothing happened before.
pub mod child {
    use std::sync::OnceLock;

    use super::{History, Message, Place};

    static HISTORY: OnceLock<History> = OnceLock::new();

    /// What happened before this process began.
    pub fn history() -> &'static History {
        HISTORY.get_or_init(History::default)
    }

    /// Says what is done from now on. Call it before a driver is entered.
    pub fn enter(place: Place) {
        send(&Message::Place(place));
    }

    /// Hands something over to the child that goes on if this one crashes.
    pub fn keep(value: serde_json::Value) {
        send(&Message::Keep(value));
    }

    #[cfg(not(unix))]
    fn send(_: &Message) {}

    #[cfg(unix)]
    use std::{
        io::{BufRead, BufReader, Read, Write},
        os::fd::AsFd,
        os::unix::net::UnixStream,
        sync::Mutex,
        sync::PoisonError,
    };

    #[cfg(unix)]
    static PARENT: Mutex<Option<UnixStream>> = Mutex::new(None);

    /// Makes this process a child. Its standard input must come from [`watch`](super::watch).
    #[cfg(unix)]
    pub fn begin() -> std::io::Result<()> {
        let stream = UnixStream::from(std::io::stdin().as_fd().try_clone_to_owned()?);
        let mut lines = BufReader::new(stream.try_clone()?);
        let mut first = String::new();
        lines.read_line(&mut first)?;
        let history = serde_json::from_str(&first)?;
        let _ = HISTORY.set(history);
        *PARENT.lock().unwrap_or_else(PoisonError::into_inner) = Some(stream);
        std::thread::spawn(move || {
            // nothing more is said; the end means that the parent is gone, or was interrupted
            let _ = lines.read_to_end(&mut Vec::new());
            diffraction_cli::interrupt::stop();
        });
        Ok(())
    }

    #[cfg(unix)]
    fn send(message: &Message) {
        let mut parent = PARENT.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(stream) = parent.as_mut()
            && let Ok(line) = serde_json::to_string(message)
        {
            // without a parent nobody needs to know
            let _ = stream.write_all((line + "\n").as_bytes());
        }
    }
}

#[cfg(unix)]
mod unix {
    use std::io::{self, BufRead, BufReader, Write};
    use std::net::Shutdown;
    use std::os::fd::OwnedFd;
    use std::os::unix::net::UnixStream;
    use std::os::unix::process::ExitStatusExt;
    use std::process::{Command, ExitStatus};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::thread;
    use std::time::{Duration, Instant};

    use diffraction_cli::interrupt::before_exit;
    use rustix::process::{Pid, Signal, kill_process};

    use super::{Crash, History, Message, Place};

    /// How long an interrupted child may take to end in order.
    const LAST_WORDS: Duration = Duration::from_millis(700);

    /// Runs a command as a child, again without the route that crashed as often as one does. Returns its exit code, or the crash
    /// after which nothing is left to try. `goes_on`: whether the command has several routes.
    pub fn watch(
        command: impl Fn() -> io::Result<Command>,
        goes_on: bool,
    ) -> io::Result<Result<i32, Crash>> {
        let mut history = History::default();
        loop {
            let (status, place, kept) = once(command()?, &history)?;
            // a command knows only these codes; 130 is an interrupt
            let code = status.code().filter(|code| [0, 1, 2, 130].contains(code));
            if let Some(code) = code {
                return Ok(Ok(code));
            }
            let crash = Crash { place, how: how(status) };
            let is_known = history.crashes.iter().any(|c| c.concerns(&crash.place.route));
            if !goes_on || is_known || crash.place.route.is_empty() {
                return Ok(Err(crash));
            }
            history.crashes.push(crash);
            history.kept.extend(kept);
        }
    }

    /// Runs one child to its end.
    fn once(
        mut command: Command,
        history: &History,
    ) -> io::Result<(ExitStatus, Place, Vec<serde_json::Value>)> {
        let (ours, theirs) = UnixStream::pair()?;
        command.stdin(OwnedFd::from(theirs));
        let mut child = command.spawn()?;
        // the command holds the child's end, whose closing is to be seen
        drop(command);
        let mut first = serde_json::to_string(history)?;
        first.push('\n');
        let (mut out, lines, end) = (ours.try_clone()?, ours.try_clone()?, ours);
        // a history may be longer than the socket's buffer
        let writer = thread::spawn(move || out.write_all(first.as_bytes()));
        let listener = thread::spawn(move || listen(lines));
        let is_over = Arc::new(AtomicBool::new(false));
        let (seen, pid) = (Arc::clone(&is_over), Pid::from_child(&child));
        let stopped = end.try_clone()?;
        let interrupted = before_exit(move || {
            let _ = stopped.shutdown(Shutdown::Both);
            let last = Instant::now() + LAST_WORDS;
            while !seen.load(Ordering::Relaxed) {
                if Instant::now() >= last {
                    let _ = kill_process(pid, Signal::KILL);
                    break;
                }
                thread::sleep(Duration::from_millis(5));
            }
        });
        let status = child.wait()?;
        is_over.store(true, Ordering::Relaxed);
        drop(interrupted);
        // what the child started may still hold its end
        let _ = end.shutdown(Shutdown::Read);
        let _ = writer.join();
        let (place, kept) = listener.join().unwrap_or_default();
        Ok((status, place, kept))
    }

    /// The last place, and all that is to be kept.
    fn listen(lines: UnixStream) -> (Place, Vec<serde_json::Value>) {
        let (mut place, mut kept) = (Place::default(), Vec::new());
        for line in BufReader::new(lines).lines() {
            let Ok(line) = line else { break };
            match serde_json::from_str(&line) {
                Ok(Message::Place(now)) => place = now,
                Ok(Message::Keep(value)) => kept.push(value),
                // cut short by the end
                Err(_) => {}
            }
        }
        (place, kept)
    }

    fn how(status: ExitStatus) -> String {
        const NAMES: [(i32, &str); 7] = [
            (4, "SIGILL"),
            (6, "SIGABRT"),
            (7, "SIGBUS"),
            (8, "SIGFPE"),
            (9, "SIGKILL, perhaps for lack of memory"),
            (11, "SIGSEGV"),
            (31, "SIGSYS"),
        ];
        match (status.signal(), status.code()) {
            (Some(signal), _) => match NAMES.iter().find(|(number, _)| *number == signal) {
                Some((number, name)) => format!("signal {number}, {name}"),
                None => format!("signal {signal}"),
            },
            (None, Some(code)) => format!("exit code {code}"),
            (None, None) => "unknown end".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crash(route: &str) -> Crash {
        Crash { place: Place { route: route.into(), ..Place::default() }, how: "signal 11".into() }
    }

    #[test]
    fn a_crash_takes_its_route_out_and_a_crash_of_listing_all_that_list_the_same() {
        let one = crash("vulkan:llvmpipe");
        assert!(one.concerns("vulkan:llvmpipe"));
        assert!(
            !["vulkan:other", "vulkan", "gl:llvmpipe", "spirv:llvmpipe"]
                .iter()
                .any(|route| one.concerns(route))
        );
        let all = crash("hlsl");
        assert!(["vulkan", "vulkan:x", "spirv:x", "hlsl:x"].iter().all(|r| all.concerns(r)));
        assert!(!["gl", "gl:x", "glsl450", "webgpu"].iter().any(|route| all.concerns(route)));
    }

    #[cfg(unix)]
    #[test]
    fn children_go_on_without_what_crashed() {
        use std::process::Command;
        // a shell as a child: it says where it is, keeps something, and crashes unless the first route did before
        let script = r#"
            read -r history
            case "$history" in
              *vulkan:a*) echo "$history" >&2; echo '{"place":{"route":"gl:b"}}' >&0; exit 1;;
            esac
            echo '{"keep":{"row":1}}' >&0
            echo '{"place":{"route":"vulkan:a","surface":"s","variant":"v"}}' >&0
            kill -SEGV $$
        "#;
        let shell = || {
            let mut command = Command::new("sh");
            command.args(["-c", script]).stderr(std::process::Stdio::null());
            Ok(command)
        };
        assert_eq!(watch(shell, true).expect("runs"), Ok(1));
        let alone = watch(shell, false).expect("runs").expect_err("crashes");
        assert_eq!(alone.how, "signal 11, SIGSEGV");
        assert_eq!(alone.place.to_string(), "drawing v on s");
        // the same route again: nothing is left to try
        let again = || {
            let mut command = Command::new("sh");
            let line = r#"read -r h; echo '{"place":{"route":"vulkan:a"}}' >&0; kill -ABRT $$"#;
            command.args(["-c", line]);
            Ok(command)
        };
        let crash = watch(again, true).expect("runs").expect_err("crashes");
        assert_eq!(crash.how, "signal 6, SIGABRT");
        let code = || {
            let mut command = Command::new("sh");
            command.args(["-c", "read -r h; exit 77"]);
            Ok(command)
        };
        assert_eq!(
            watch(code, true).expect("runs").expect_err("no code of ours").how,
            "exit code 77"
        );
    }
}

//! naga in this process, and the command-line validators.

use std::{
    env, fs,
    io::{self, Read},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::mpsc::{Receiver, channel},
    thread,
    time::{Duration, Instant},
};

use naga::valid::{Capabilities, ValidationFlags, Validator};

use super::Tool;

/// Time that a tool has for one file.
const TIME_LIMIT: Duration = Duration::from_secs(60);

/// Time between two looks at a running tool.
const POLL: Duration = Duration::from_millis(2);

/// All validators, installed or not.
pub fn tools() -> Vec<Box<dyn Tool>> {
    vec![
        Box::new(Naga),
        // Vulkan's rules are stricter than those of SPIR-V alone
        Box::new(External::new("spirv-val", Some("spirv-tools"), Reads::Spirv, |_| {
            vec![vec!["--target-env", "vulkan1.0"]]
        })),
        Box::new(External::new("glslangValidator", Some("glslang-tools"), Reads::Glsl, |name| {
            vec![vec!["-S", if name.contains(".vert") { "vert" } else { "frag" }]]
        })),
        Box::new(External::new("spirv-cross", Some("spirv-cross"), Reads::Spirv, |_| {
            vec![vec!["--version", "450"], vec!["--version", "300", "--es"]]
        })),
        // without a format it guesses one from the name of an output file, of which there is none
        Box::new(External::new("tint", None, Reads::Wgsl, |_| vec![vec!["--format", "wgsl"]])),
    ]
}

/// Reads WGSL again in this process.
pub struct Naga;

impl Tool for Naga {
    fn name(&self) -> &str {
        "naga"
    }

    fn package(&self) -> Option<&str> {
        None
    }

    fn version(&self) -> Option<String> {
        Some("in process".to_owned())
    }

    fn reads(&self, name: &str) -> bool {
        Reads::Wgsl.name(name)
    }

    fn check(&self, file: &Path) -> Result<(), String> {
        let text = fs::read_to_string(file).map_err(|error| error.to_string())?;
        let module = naga::front::wgsl::parse_str(&text).map_err(|e| e.emit_to_string(&text))?;
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        validator.validate(&module).map(|_| ()).map_err(|error| error.emit_to_string(&text))
    }
}

/// The language that a tool reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reads {
    /// WGSL modules, not fragments of them.
    Wgsl,
    /// GLSL of both kinds, whole shaders.
    Glsl,
    /// SPIR-V.
    Spirv,
}

impl Reads {
    fn name(self, name: &str) -> bool {
        let function_only = name.ends_with(".fn.wgsl") || name.ends_with(".fn.glsl");
        let suffixes: &[&str] = match self {
            Reads::Wgsl => &[".wgsl"],
            Reads::Glsl => &[".vert.glsl", ".frag.glsl", ".es300.vert", ".es300.frag"],
            Reads::Spirv => &[".spv"],
        };
        !function_only && suffixes.iter().any(|suffix| name.ends_with(suffix))
    }
}

/// A validator on the command line: it gets options and the file, and says by its exit code what it thinks.
pub struct External {
    name: &'static str,
    package: Option<&'static str>,
    program: Option<PathBuf>,
    reads: Reads,
    /// Options of each run over a file of that name.
    options: fn(&str) -> Vec<Vec<&'static str>>,
    time_limit: Duration,
}

impl External {
    /// A tool that is looked for on the PATH.
    pub fn new(
        name: &'static str,
        package: Option<&'static str>,
        reads: Reads,
        options: fn(&str) -> Vec<Vec<&'static str>>,
    ) -> External {
        External { name, package, program: on_path(name), reads, options, time_limit: TIME_LIMIT }
    }

    /// Gives it less, or more, time for one file.
    #[must_use]
    pub fn time_limit(mut self, limit: Duration) -> External {
        self.time_limit = limit;
        self
    }

    fn command(&self) -> Option<Command> {
        self.program.as_ref().map(Command::new)
    }
}

impl Tool for External {
    fn name(&self) -> &str {
        self.name
    }

    fn package(&self) -> Option<&str> {
        self.package
    }

    fn version(&self) -> Option<String> {
        let mut command = self.command()?;
        // spirv-cross tells its revision, tint nothing at all
        let question = if self.name == "spirv-cross" { "--revision" } else { "--version" };
        let answer = run(command.arg(question), self.time_limit).ok();
        let told = answer.filter(|(status, _)| status.success()).and_then(|(_, text)| {
            let line = text.lines().map(str::trim).find(|line| !line.is_empty())?;
            Some(line.to_owned())
        });
        Some(told.unwrap_or_else(|| "unknown version".to_owned()))
    }

    fn reads(&self, name: &str) -> bool {
        self.reads.name(name)
    }

    fn check(&self, file: &Path) -> Result<(), String> {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        for options in (self.options)(&name) {
            let mut command = self.command().ok_or("not installed")?;
            // an absolute path, so that no file name is taken for an option
            let file = fs::canonicalize(file).map_err(|error| error.to_string())?;
            command.args(&options).arg(file);
            let (status, text) =
                run(&mut command, self.time_limit).map_err(|error| error.to_string())?;
            if !status.success() {
                return Err(format!(
                    "{} {}: {status}\n{}",
                    self.name,
                    options.join(" "),
                    text.trim()
                ));
            }
        }
        Ok(())
    }
}

/// The program of that name in the first folder of the PATH that has it.
fn on_path(name: &str) -> Option<PathBuf> {
    let path = env::var_os("PATH")?;
    let programs = env::split_paths(&path)
        .map(|folder| folder.join(format!("{name}{}", env::consts::EXE_SUFFIX)));
    programs.into_iter().find(|program| program.is_file())
}

/// Exit status and all that was written, standard error first; an error after the time limit.
fn run(command: &mut Command, limit: Duration) -> io::Result<(ExitStatus, String)> {
    let command = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn()?;
    let streams = [child.stderr.take().map(drain), child.stdout.take().map(drain)];
    let end = Instant::now() + limit;
    let status = wait(&mut child, end, limit)?;
    let mut text = String::new();
    for stream in streams.into_iter().flatten() {
        // a process that the tool left behind may hold the stream open
        let left = end.saturating_duration_since(Instant::now());
        let bytes = stream.recv_timeout(left).unwrap_or_default();
        text.push_str(&String::from_utf8_lossy(&bytes));
    }
    Ok((status, text))
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
        // what was read before an error is still worth showing
        let _ = stream.read_to_end(&mut bytes);
        let _ = sender.send(bytes);
    });
    receiver
}

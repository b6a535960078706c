//! The harness, another program: its commands, and how it is found and started.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::{Context, Error, Result, bail};

use crate::console::MessageFormat;
use crate::{Program, program, replace};

/// Name of the harness's program.
pub const NAME: &str = "diffraction-harness";

/// The commands that only the harness has, each with one line of help.
pub const COMMANDS: [(&str, &str); 9] = [
    ("import", "Convert files of instruments to Gwyddion Simple Field, which plans read"),
    ("validate", "Check every emitted shader with external validators"),
    (
        "compare",
        "Compare the colours of every variant, by every route, with the exact reference, its twin and the other routes",
    ),
    ("testbench", "Measure a surface's period from its response over wavelength and viewing angle"),
    ("bench", "Measure the frame time of every variant on every adapter"),
    ("tune", "Find the cheapest variant of a surface within an error budget"),
    ("scene", "Draw a variant as the skin of a 3-D body: pictures, sweeps, a turntable"),
    ("report", "Show the results of compare, bench, testbench and tune on one HTML page"),
    ("serve", "Serve the gallery to a browser on this machine"),
];

/// Whether a command line asks for one of [`COMMANDS`], or for help on one. The program's name comes first.
pub(crate) fn is_asked(args: &[OsString]) -> bool {
    let mut words = args.iter().skip(1).map(OsString::as_os_str);
    let mut next = || loop {
        let word = words.next()?;
        if word == "--message-format" {
            words.next();
        } else if !word.as_encoded_bytes().starts_with(b"--message-format=") {
            return Some(word);
        }
    };
    let has = |word: &OsStr| COMMANDS.iter().any(|(name, _)| word == *name);
    match next() {
        Some(word) if word == "help" => next().is_some_and(has),
        word => word.is_some_and(has),
    }
}

/// The format of diagnostics that a command line asks for. Only the harness parses the whole line.
pub(crate) fn message_format(args: &[OsString]) -> MessageFormat {
    let json = args.iter().any(|word| word == "--message-format=json")
        || args.windows(2).any(|pair| pair[0] == "--message-format" && pair[1] == "json");
    if json { MessageFormat::Json } else { MessageFormat::Human }
}

/// Replaces this process by the harness with the same arguments. Returns only if that failed.
pub(crate) fn take_over(program: &Program, args: &[OsString]) -> Error {
    match (program.harness)() {
        Ok(path) => replace::by(call(path, program.name, args)),
        Err(error) => error,
    }
}

fn call(path: PathBuf, name: &str, args: &[OsString]) -> Command {
    let mut command = Command::new(path);
    command.args(args.iter().skip(1)).env(program::CALLED_AS, name);
    command
}

/// Path of the installed harness: in this program's folder, else on the PATH. Its version must be this program's.
pub fn installed() -> Result<PathBuf> {
    let file = format!("{NAME}{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe().map(|own| own.with_file_name(&file));
    // the system searches the PATH for a bare name
    let path = beside.ok().filter(|path| path.is_file()).unwrap_or_else(|| file.into());
    let said = Command::new(&path).arg("--version").stdin(Stdio::null()).output();
    let said = match said {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => bail!(
            "this command needs the program {NAME}, which is neither in this program's folder nor on the PATH; install it: \
             cargo install --path harness"
        ),
        said => said.with_context(|| format!("{} cannot be started", path.display()))?,
    };
    let said = String::from_utf8_lossy(&said.stdout);
    let (version, own) =
        (said.split_whitespace().last().unwrap_or("unknown"), env!("CARGO_PKG_VERSION"));
    if version != own {
        bail!(
            "{} has version {version} and this program {own}; install both from one checkout: \
             cargo install --path cli && cargo install --path harness",
            path.display()
        );
    }
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<OsString> {
        line.split(' ').map(OsString::from).collect()
    }

    #[test]
    fn commands_of_the_harness_are_known_by_their_names() {
        for line in [
            "xtask compare --size 64",
            "xtask --message-format json bench",
            "xtask --message-format=json report a b",
            "xtask help scene",
            "xtask validate --help",
        ] {
            assert!(is_asked(&words(line)), "{line}");
        }
        for line in [
            "xtask",
            "xtask generate --out compare",
            "xtask --help",
            "xtask help",
            "xtask help list",
            "xtask compares",
        ] {
            assert!(!is_asked(&words(line)), "{line}");
        }
    }

    #[test]
    fn arguments_are_handed_over_as_they_are() {
        let args = words("xtask compare  --out=a  --json");
        let command = call("harness".into(), "cargo xtask", &args);
        assert!(command.get_args().eq(args.iter().skip(1)));
    }
}

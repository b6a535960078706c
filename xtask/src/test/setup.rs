//! Installs the Debian packages that the tests need, if that needs no password; then the libraries of npm and pip.

use super::{deny, modules};
use std::{
    env, fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

/// Whether the tests can run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// Everything is installed.
    Ready,
    /// Something is missing. The remedy was printed.
    Missing,
}

/// Installs missing packages. `root` is the workspace.
pub fn run(root: &Path) -> anyhow::Result<Outcome> {
    match packages() {
        Outcome::Ready => {}
        Outcome::Missing => return Ok(Outcome::Missing),
    }
    match modules::run(root)? {
        Outcome::Ready => deny::install(root),
        Outcome::Missing => Ok(Outcome::Missing),
    }
}

fn packages() -> Outcome {
    let missing = missing(&Machine::look());
    if missing.is_empty() {
        return Outcome::Ready;
    }
    let list = missing.join(" ");
    let advice =
        format!("sudo apt-get update && sudo apt-get install -y --no-install-recommends {list}");
    if find("apt-get").is_none() {
        eprintln!(
            "the tests need these Debian packages, or your system's equivalents: {list}; install them, or pass --no-setup"
        );
        return Outcome::Missing;
    }
    let Some(prefix) = privilege() else {
        eprintln!("the tests need {list}; run\n  {advice}\nor pass --no-setup");
        return Outcome::Missing;
    };
    eprintln!("== setup: apt-get install {list}");
    // if this fails, an old list of packages may suffice
    apt(prefix, &["update", "-q"]);
    let mut arguments = vec!["install", "-q", "-y", "--no-install-recommends"];
    arguments.extend(&missing);
    let installed = apt(prefix, &arguments);
    let left = self::missing(&Machine::look());
    if !installed || !left.is_empty() {
        eprintln!("{list}: could not be installed; run\n  {advice}\nor pass --no-setup");
        return Outcome::Missing;
    }
    Outcome::Ready
}

/// How to find out that a package is installed, whoever installed it.
enum Sign {
    /// A program on the PATH.
    Program(&'static str),
    /// A library that the loader knows, by the beginning of its file name.
    Library(&'static str),
    /// A file of Mesa's GL drivers; later versions have a library instead.
    Dri,
    /// A module of Python that runs.
    Module(&'static str),
    /// The description of a Vulkan driver, by the beginning of its file name.
    VulkanDriver(&'static str),
}

const PACKAGES: [(&str, Sign); 14] = [
    ("mesa-vulkan-drivers", Sign::VulkanDriver("lvp_icd")),
    ("libvulkan1", Sign::Library("libvulkan.so.1")),
    ("libegl1", Sign::Library("libEGL.so.1")),
    ("libgles2", Sign::Library("libGLESv2.so.2")),
    // Python's OpenGL loads this
    ("libgl1", Sign::Library("libGL.so.1")),
    // llvmpipe itself, which libegl1 does not depend on in Debian 12
    ("libgl1-mesa-dri", Sign::Dri),
    ("spirv-tools", Sign::Program("spirv-val")),
    ("glslang-tools", Sign::Program("glslangValidator")),
    ("spirv-cross", Sign::Program("spirv-cross")),
    // compiles and runs Metal texts
    ("g++", Sign::Program("g++")),
    // a browser, which contains SwiftShader, a second Vulkan driver
    ("chromium", Sign::Program("chromium")),
    // node builds the gallery, npm installs its libraries
    ("nodejs", Sign::Program("node")),
    ("npm", Sign::Program("npm")),
    // a separate folder for pip's libraries
    ("python3-venv", Sign::Module("ensurepip")),
];

/// The signs found on this machine.
struct Machine {
    programs: Vec<&'static str>,
    libraries: String,
    vulkan_drivers: Vec<String>,
    installed: Vec<&'static str>,
}

impl Machine {
    fn look() -> Machine {
        let programs = PACKAGES.iter().filter_map(|(_, sign)| match sign {
            Sign::Program(name) => find(name).map(|_| *name),
            Sign::Module(name) => output("python3", &["-m", name, "--version"]).map(|_| *name),
            _ => None,
        });
        let folders =
            ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
        let drivers =
            folders.iter().filter_map(|folder| fs::read_dir(folder).ok()).flatten().flatten();
        let ldconfig = ["ldconfig", "/sbin/ldconfig"].iter().find_map(|name| output(name, &["-p"]));
        let installed = |name: &str| {
            output("dpkg-query", &["-W", "-f=${Status}", name])
                .is_some_and(|s| s == "install ok installed")
        };
        Machine {
            programs: programs.collect(),
            libraries: ldconfig.unwrap_or_default(),
            vulkan_drivers: drivers
                .map(|entry| entry.file_name().to_string_lossy().into_owned())
                .collect(),
            installed: PACKAGES
                .iter()
                .map(|(name, _)| *name)
                .filter(|name| installed(name))
                .collect(),
        }
    }

    fn shows(&self, package: &str, sign: &Sign) -> bool {
        let library =
            |name: &str| self.libraries.lines().any(|line| line.trim_start().starts_with(name));
        self.installed.contains(&package)
            || match sign {
                Sign::Program(name) | Sign::Module(name) => self.programs.contains(name),
                Sign::Library(name) => library(name),
                Sign::Dri => library("libgallium"),
                Sign::VulkanDriver(name) => {
                    self.vulkan_drivers.iter().any(|file| file.starts_with(name))
                }
            }
    }
}

fn missing(machine: &Machine) -> Vec<&'static str> {
    PACKAGES
        .iter()
        .filter(|(package, sign)| !machine.shows(package, sign))
        .map(|(package, _)| *package)
        .collect()
}

/// The prefix of the apt-get command; `None` if it would need a password.
fn privilege() -> Option<&'static [&'static str]> {
    if output("id", &["-u"])?.trim() == "0" {
        return Some(&[]);
    }
    output("sudo", &["-n", "true"]).map(|_| ["sudo", "-n"].as_slice())
}

fn apt(prefix: &[&str], arguments: &[&str]) -> bool {
    let line = [prefix, &["env", "DEBIAN_FRONTEND=noninteractive", "apt-get"], arguments].concat();
    // its output goes to stderr, as all diagnostics do
    let status = Command::new(line[0])
        .args(&line[1..])
        .stdin(Stdio::null())
        .stdout(std::io::stderr())
        .status();
    status.is_ok_and(|status| status.success())
}

/// The output of a program, if it succeeds.
fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).stdin(Stdio::null()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

fn find(program: &str) -> Option<PathBuf> {
    let path = env::var_os("PATH")?;
    env::split_paths(&path).map(|folder| folder.join(program)).find(|file| file.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_package_is_known_by_its_name_or_by_its_sign() {
        let bare = Machine {
            programs: vec![],
            libraries: String::new(),
            vulkan_drivers: vec!["intel_icd.x86_64.json".to_owned()],
            installed: vec![],
        };
        assert_eq!(missing(&bare).len(), PACKAGES.len());
        let some = Machine {
            programs: vec!["spirv-val", "g++", "node", "npm", "ensurepip"],
            libraries:
                "2 libs found\n\tlibEGL.so.1 (libc6) => there\n\tlibgallium-25.so (libc6) => there"
                    .to_owned(),
            vulkan_drivers: vec!["lvp_icd.x86_64.json".to_owned()],
            installed: vec!["libvulkan1", "spirv-cross"],
        };
        assert_eq!(missing(&some), ["libgles2", "libgl1", "glslang-tools", "chromium"]);
    }
}

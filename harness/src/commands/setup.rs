//! What commands install for themselves: from Python's package index, in recorded versions, each with its hash.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};
use diffraction_cli::console::Console;
use diffraction_cli::interrupt::TemporaryFolder;
use diffraction_shaders::disk::{Access, FolderLock};

use crate::process::{on_path, to_its_end, tools_folder};

const SCRIPT: &str = include_str!("../../python/setup.py");

/// Something that can be installed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    /// What the script calls it.
    kind: &'static str,
    /// Its folder below [`tools_folder`].
    folder: &'static str,
    /// Versions and hashes.
    list: &'static str,
}

/// DXC's library.
pub(super) const DXC: Item =
    Item { kind: "dxc", folder: "dxc", list: include_str!("../../python/dxc.txt") };
/// A virtual environment with what reads files of instruments.
pub(super) const IMPORT: Item =
    Item { kind: "environment", folder: "import", list: include_str!("../../python/import.txt") };

impl Item {
    /// Its folder.
    pub(super) fn folder(&self) -> PathBuf {
        tools_folder().join(self.folder)
    }

    /// Installs it, unless the same versions are there. The output of what it runs goes to stderr.
    pub(super) fn install(&self, console: &Console) -> Result<()> {
        let Some(python) = on_path("python3") else {
            bail!("--setup needs Python 3.11 or later; apt-get install python3-venv");
        };
        let folder = self.folder();
        // a second command waits, and then finds it installed
        let waiting = |text: &str| console.note(text);
        let _lock = FolderLock::take(&folder, Access::Write, &waiting)?;
        let place = TemporaryFolder::new().context("a temporary folder cannot be created")?;
        let list = place.path().join("list.txt");
        std::fs::write(&list, self.list).context("the list of packages cannot be written")?;
        let mut command = Command::new(&python);
        command.args(["-I", "-c", SCRIPT, self.kind]).args([&folder, &list]);
        command.stdin(Stdio::null()).stdout(std::io::stderr());
        let status = to_its_end(&mut command)
            .with_context(|| format!("{} cannot be started", python.display()))?;
        if !status.success() {
            bail!("{}: could not be set up; see the messages above", folder.display());
        }
        console.note(&format!("{} is set up", folder.display()));
        Ok(())
    }
}

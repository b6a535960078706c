//! What commands install for themselves: Python packages in recorded versions, each with its hash.

use anyhow::Result;
use diffraction_cli::console::Console;

pub(super) fn dxc(_console: &Console) -> Result<()> {
    anyhow::bail!("later")
}

//! Files and folders of the outside world, handled so that nothing of anybody's is lost: whole files, locks of folders,
//! mounts, owners, space for what one run computes.

mod lock;
mod mount;
mod owner;
mod spill;
mod whole;

pub(crate) use lock::lock_new;
pub use lock::{Access, FolderLock, resolve};
pub use mount::{is_mount, remove_tree};
pub use owner::{owner, touchable};
pub use spill::{Spill, Spilled};
pub use whole::{clear, open_regular, read_regular, write_whole};

//! Vulkan drivers that a machine has and Vulkan's loader does not look for.

use std::{
    env,
    ffi::OsString,
    path::{Path, PathBuf},
};

/// The environment variable by which the loader (1.3.207 or later) takes drivers in addition to those of the system.
///
/// It must be set before the process loads Vulkan, hence before it starts.
pub const ADD_DRIVERS: &str = "VK_ADD_DRIVER_FILES";

/// Variables by which a user has chosen drivers already.
const CHOSEN: [&str; 3] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES", ADD_DRIVERS];

/// Folders in which the loader looks.
const SYSTEM: [&str; 5] = [
    "/usr/local/etc/vulkan/icd.d",
    "/usr/local/share/vulkan/icd.d",
    "/etc/xdg/vulkan/icd.d",
    "/etc/vulkan/icd.d",
    "/usr/share/vulkan/icd.d",
];

/// SwiftShader's description, as browsers bring it.
const SWIFTSHADER: &str = "vk_swiftshader_icd.json";
/// Where browsers are installed: Debian's, others', Google's.
const BROWSERS: [&str; 5] = [
    "/usr/lib/chromium",
    "/usr/lib64/chromium",
    "/usr/lib64/chromium-browser",
    "/opt/chromium.org/chromium",
    "/opt/google/chrome",
];

/// Descriptions of drivers that exist in well-known places and are not loaded by themselves: SwiftShader, from the first browser
/// that has it. None where the environment names drivers already.
///
/// [`ADD_DRIVERS`] takes them, joined as paths are in `PATH`.
pub fn unloaded() -> Vec<PathBuf> {
    let chosen = CHOSEN.iter().any(|name| env::var_os(name).is_some_and(|v| !v.is_empty()));
    if chosen { Vec::new() } else { unloaded_of(&|file| file.is_file()) }
}

/// The value for [`ADD_DRIVERS`]; `None` where there is nothing to add.
pub fn addition() -> Option<OsString> {
    let files = unloaded();
    if files.is_empty() { None } else { env::join_paths(files).ok() }
}

fn unloaded_of(exists: &dyn Fn(&Path) -> bool) -> Vec<PathBuf> {
    let in_folder =
        |folder: &&str| Some(Path::new(*folder).join(SWIFTSHADER)).filter(|f| exists(f));
    if SYSTEM.iter().any(|folder| in_folder(folder).is_some()) {
        return Vec::new();
    }
    BROWSERS.iter().find_map(in_folder).into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn swiftshader_comes_from_one_browser_unless_the_system_has_it() {
        let of = |files: &[&str]| unloaded_of(&|file| files.iter().any(|f| Path::new(f) == file));
        let (debian, chrome) = (
            "/usr/lib/chromium/vk_swiftshader_icd.json",
            "/opt/google/chrome/vk_swiftshader_icd.json",
        );
        assert!(of(&[]).is_empty());
        assert_eq!(of(&[chrome]), [Path::new(chrome)]);
        assert_eq!(of(&[chrome, debian]), [Path::new(debian)]);
        assert!(of(&[debian, "/etc/vulkan/icd.d/vk_swiftshader_icd.json"]).is_empty());
    }
}

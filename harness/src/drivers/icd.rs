//! Installed Vulkan drivers that Vulkan's loader does not find by itself.

use std::{
    env,
    ffi::OsString,
    path::{Path, PathBuf},
};

/// The environment variable that adds drivers to those of the system (loader 1.3.207 or later).
///
/// It must be set before the process loads Vulkan, so before the process starts.
pub const ADD_DRIVERS: &str = "VK_ADD_DRIVER_FILES";

/// Variables by which a user chooses drivers.
const CHOSEN: [&str; 3] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES", ADD_DRIVERS];

/// Folders that the loader searches.
const SYSTEM: [&str; 5] = [
    "/usr/local/etc/vulkan/icd.d",
    "/usr/local/share/vulkan/icd.d",
    "/etc/xdg/vulkan/icd.d",
    "/etc/vulkan/icd.d",
    "/usr/share/vulkan/icd.d",
];

/// File name of SwiftShader's description in browsers.
const SWIFTSHADER: &str = "vk_swiftshader_icd.json";
/// Folders of browsers: Debian's, other distributions', Google's.
const BROWSERS: [&str; 5] = [
    "/usr/lib/chromium",
    "/usr/lib64/chromium",
    "/usr/lib64/chromium-browser",
    "/opt/chromium.org/chromium",
    "/opt/google/chrome",
];

/// Descriptions of drivers in known places that the loader does not search: SwiftShader, from the first browser that has it. Empty
/// if the environment already chooses drivers.
///
/// [`ADD_DRIVERS`] takes them, joined like `PATH`.
pub fn unloaded() -> Vec<PathBuf> {
    let chosen = CHOSEN.iter().any(|name| env::var_os(name).is_some_and(|v| !v.is_empty()));
    if chosen { Vec::new() } else { unloaded_of(&|file| file.is_file()) }
}

/// The value for [`ADD_DRIVERS`]; `None` if there is no driver to add.
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

//! The format of a file: by its extension, checked by its first bytes.

use std::path::Path;

use super::{import, text};
use crate::error::{Error, Result};
use crate::surface::gsf;

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Png,
    Tiff,
    Exr,
    Npy,
    Gsf,
    Text,
}

/// Extensions of instruments, of programs that evaluate their files, and of containers: converted by `import`.
const INSTRUMENTS: [&str; 45] = [
    "3ds",
    "al3d",
    "ardf",
    "bcr",
    "bcrf",
    "crd",
    "datx",
    "di",
    "dm3",
    "dm4",
    "ezd",
    "gwy",
    "gxyzf",
    "h5",
    "hdf5",
    "ibw",
    "jpk",
    "jpk-qi-data",
    "mat",
    "mdt",
    "mi",
    "mnt",
    "nc",
    "nid",
    "nhf",
    "nms",
    "nmm",
    "opd",
    "opdx",
    "os3d",
    "plu",
    "plux",
    "plx",
    "ps-ppt",
    "sdf",
    "sm2",
    "sm4",
    "spm",
    "stp",
    "sur",
    "sxm",
    "top",
    "vk4",
    "vk6",
    "x3p",
];

/// Extensions that are read.
const READ: &str = "png, tif, tiff, exr, npy, gsf, txt, csv, asc, dat, xyz, prn, tsv, grd";

impl Format {
    fn of_extension(extension: &str) -> Option<Format> {
        Some(match extension {
            "png" => Format::Png,
            "tif" | "tiff" => Format::Tiff,
            "exr" => Format::Exr,
            "npy" => Format::Npy,
            "gsf" => Format::Gsf,
            "txt" | "csv" | "asc" | "dat" | "xyz" | "prn" | "tsv" | "grd" => Format::Text,
            _ => return None,
        })
    }

    /// The format by the first bytes. Content without another format's mark and without control characters is text.
    fn of_content(bytes: &[u8]) -> Option<Format> {
        let marks: [(&[u8], Format); 8] = [
            (b"\x89PNG\r\n\x1a\n", Format::Png),
            (b"II*\0", Format::Tiff),
            (b"MM\0*", Format::Tiff),
            (b"II+\0", Format::Tiff),
            (b"MM\0+", Format::Tiff),
            (b"\x76\x2f\x31\x01", Format::Exr),
            (b"\x93NUMPY", Format::Npy),
            (gsf::MAGIC, Format::Gsf),
        ];
        let marked =
            marks.iter().find(|(mark, _)| bytes.starts_with(mark)).map(|&(_, format)| format);
        marked.or_else(|| text::is_text(bytes).then_some(Format::Text))
    }

    fn name(self) -> &'static str {
        match self {
            Format::Png => "PNG",
            Format::Tiff => "TIFF",
            Format::Exr => "OpenEXR",
            Format::Npy => "NPY",
            Format::Gsf => "Gwyddion Simple Field",
            Format::Text => "text",
        }
    }
}

/// The extension of a path, in lower case; empty if it has none.
fn extension(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase()
}

/// The format that belongs to the extension.
pub(super) fn of_path(path: &Path, subject: &str) -> Result<Format> {
    let extension = extension(path);
    Format::of_extension(&extension).ok_or_else(|| {
        let error = |cause: String| Error::new(subject, cause);
        let import = import(path);
        // NanoScope numbers its files: scan.001
        let is_number = !extension.is_empty() && extension.bytes().all(|b| b.is_ascii_digit());
        if is_number || INSTRUMENTS.contains(&extension.as_str()) {
            return error(format!(
                "`{extension}` is a format of instruments, which a plan does not read"
            ))
            .remedy(format!(
                "convert it with `{import}`, which writes a GSF file beside it, and name that"
            ));
        }
        error(format!("the extension `{extension}` does not belong to a known format")).remedy(
            format!("name a file of {READ}; a file of an instrument is converted with `{import}`"),
        )
    })
}

/// Checks that the content matches the extension.
pub(super) fn check_content(
    format: Format,
    bytes: &[u8],
    path: &Path,
    subject: &str,
) -> Result<()> {
    let error = |cause: String| Error::new(subject, cause);
    if bytes.is_empty() {
        return Err(error("the file is empty".into()).remedy("export it again"));
    }
    let (extension, name) = (extension(path), format.name());
    match Format::of_content(bytes) {
        Some(found) if found == format => Ok(()),
        Some(found) => {
            let found = found.name();
            Err(error(format!(
                "the content is {found}, although the extension `{extension}` stands for {name}"
            ))
            .remedy("rename or convert the file"))
        }
        None if format == Format::Text => Err(error(format!(
            "the content is not text, although the extension is `{extension}`"
        ))
        .remedy(format!(
            "if it is an instrument's file, convert it with `{}`; otherwise it has the wrong name or is damaged",
            import(path)
        ))),
        None => Err(error(format!(
            "the content is not {name}, although the extension is `{extension}`"
        ))
        .remedy("the file is damaged or has the wrong name; export it again")),
    }
}

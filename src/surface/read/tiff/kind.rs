//! TIFFs that hold no readable heights: which kind they are, and what to do.

use crate::error::{Error, Result};

/// Values of the tag `Compression` (TIFF 6.0 and the numbers of libtiff) that are read: none, LZW, deflate in two numbers,
/// PackBits.
const READ: [u32; 5] = [1, 5, 8, 32946, 32773];

/// Names of the others.
const NAMES: [(u32, &str); 12] = [
    (2, "CCITT run lengths"),
    (3, "CCITT fax 3"),
    (4, "CCITT fax 4"),
    (6, "JPEG"),
    (7, "JPEG"),
    (34712, "JPEG 2000"),
    (34887, "LERC"),
    (34925, "LZMA"),
    (50000, "Zstandard"),
    (50001, "WebP"),
    (50002, "JPEG XL"),
    (34892, "JPEG"),
];

/// Tags of the directory that tell the kind.
pub(super) struct Tags {
    pub compression: u32,
    /// `PhotometricInterpretation`.
    pub colours: u32,
    /// Whether the private tag 50432 of Park Systems is there.
    pub is_park: bool,
}

/// An error for kinds whose heights cannot be read from the picture.
pub(super) fn check(tags: &Tags, subject: &str, import: &str) -> Result<()> {
    let error = |cause: String| Error::new(subject, cause);
    if tags.is_park {
        return Err(error("is a TIFF of Park Systems: its picture is a preview in false colours, and the heights are in private tags".into())
            .remedy(format!("convert it with `{import}`")));
    }
    if !READ.contains(&tags.compression) {
        let name = NAMES.iter().find(|(number, _)| *number == tags.compression).map_or_else(
            || format!("method {}", tags.compression),
            |(_, name)| format!("{name} (method {})", tags.compression),
        );
        return Err(error(format!("the TIFF is compressed with {name}, which is not read"))
            .remedy("export it without compression, or with LZW or deflate; the heights may also have been changed by a lossy method"));
    }
    let (what, remedy) = match tags.colours {
        3 => (
            "the TIFF has a palette: its numbers are places in a list of colours, not heights",
            "export the heights as 16-bit grey or 32-bit floats; false colours cannot be converted back",
        ),
        4 => ("the TIFF is a transparency mask", "export grey heights"),
        5 => ("the TIFF has the inks of a printer (CMYK)", "export grey heights"),
        6 => ("the TIFF has video colours (YCbCr)", "export grey heights without JPEG"),
        8..=10 => ("the TIFF has L*a*b* colours", "export grey heights"),
        _ => return Ok(()),
    };
    Err(error(what.into()).remedy(remedy))
}

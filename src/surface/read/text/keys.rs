//! The keys of headers of text files: of Gwyddion's text export (in its languages), SPIP and Attocube ASCII (`x-pixels`,
//! `x-length`, `z-unit`, `Bit2nm`), NT-MDT Nova (`NX`, `Scale X`, `Unit Data`), WSxM (`X Amplitude`), NanoScope (`Samps/line`,
//! `Scan Size`), ESRI grids (`ncols`, `cellsize`, `NODATA_value`), and what people write by hand. Only letters and digits of a
//! key matter.

use Axis::{Both, X, Y};

/// What a key states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Key {
    Channel,
    /// Sizes of the patch along x, along y, or both.
    Size(Axis),
    /// The same, in nm where there is no unit (SPIP).
    Length(Axis),
    Pitch(Axis),
    Pixels(Axis),
    Unit(Axis),
    /// Unit of the numbers.
    Heights,
    /// The unit of this range is that of the numbers (WSxM).
    Amplitude,
    /// nm per number (SPIP).
    Bit2nm,
    /// Factor of the numbers, and whether it is still to be applied (Nova).
    Scale,
    ScaleNeeded,
    Void,
    /// Places and times, which change nothing.
    Known,
}

/// The axes that a length belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axis {
    X,
    Y,
    Both,
}

const KEYS: [(Key, &str); 22] = [
    (Key::Channel, "channel kanal kanál canal canale チャネル канал display channelname"),
    (
        Key::Size(X),
        "width breite šířka largeur larghezza anchura 幅 ширина xamplitude xreal xrange xsize sizex scansizex xscansize fieldwidth",
    ),
    (
        Key::Size(Y),
        "height höhe výška hauteur altezza altura 高さ высота yamplitude yreal yrange ysize sizey scansizey yscansize fieldheight",
    ),
    (Key::Size(Both), "scansize imagesize fieldsize"),
    (Key::Length(X), "xlength"),
    (Key::Length(Y), "ylength"),
    (
        Key::Pitch(X),
        "dx scalex xscale xstep stepx pixelsizex xpixelsize pixelwidth xpitch xspacing xincrement",
    ),
    (
        Key::Pitch(Y),
        "dy scaley yscale ystep stepy pixelsizey ypixelsize pixelheight ypitch yspacing yincrement",
    ),
    (
        Key::Pitch(Both),
        "cellsize pixelsize pitch pixelpitch spacing pixelspacing lateralresolution",
    ),
    (
        Key::Pixels(X),
        "xpixels ncols nx xres columns numberofcolumns sampsline xpoints numberofpoints",
    ),
    (Key::Pixels(Y), "ypixels nrows ny yres rows numberofrows lines numberoflines ypoints"),
    (Key::Unit(Both), "xyunits xyunit lateralunit lateralunits xyunitsare"),
    (Key::Unit(X), "xunit xunits unitx"),
    (Key::Unit(Y), "yunit yunits unity"),
    (
        Key::Heights,
        "valueunits valueunit jednotkyhodnot einheiten unités unitàvalore unidadesdevalor 値の単位 единицыизмерения zunit zunits unitz unitdata dataunit dataunits heightunit heightunits unit units",
    ),
    (Key::Amplitude, "zamplitude"),
    (Key::Bit2nm, "bit2nm"),
    (Key::Scale, "scaledata"),
    (Key::ScaleNeeded, "datascaleneeded"),
    (Key::Void, "nodatavalue nodata voidvalue missingvalue fillvalue novalue"),
    (
        Key::Known,
        "xllcorner yllcorner xllcenter yllcenter xoffset yoffset voidpixels scanspeed description fileformat originalfile biasx biasy biasdata title comment date time",
    ),
    (Key::Known, "startofdata startdata data"),
];

/// The key of a line, if it is known.
pub(super) fn key_of(text: &str) -> Option<Key> {
    let bare: String = text.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect();
    KEYS.iter().find(|(_, names)| names.split(' ').any(|name| name == bare)).map(|(key, _)| *key)
}

//! A canvas for rectangles, lines, labels and a colour map.

use crate::encode::{self, Picture};
use crate::error::Result;

use super::font;

pub(super) type Colour = [u8; 3];

pub(super) const PAPER: Colour = [255, 255, 255];
pub(super) const INK: Colour = [40, 40, 40];
/// Background of places without a value.
pub(super) const NIGHT: Colour = [18, 18, 22];

/// Pixels of the picture per pixel of the font.
const FONT_SCALE: i64 = 2;
/// Distance from one character to the next.
pub(super) const ADVANCE: i64 = (font::WIDTH as i64 + 1) * FONT_SCALE;
/// Height of a line of capitals.
pub(super) const LINE: i64 = 7 * FONT_SCALE;

/// Where a label stands relative to its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Align {
    Left,
    Centre,
    Right,
}

pub(super) struct Canvas(Picture);

impl Canvas {
    pub(super) fn new(width: i64, height: i64) -> Canvas {
        let (width, height) = (width.max(1) as u32, height.max(1) as u32);
        let texels = vec![opaque(PAPER); width as usize * height as usize];
        Canvas(Picture { width, height, texels })
    }

    /// Sets a pixel. Pixels outside the picture are ignored.
    pub(super) fn set(&mut self, x: i64, y: i64, colour: Colour) {
        if let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y))
            && x < self.0.width
            && y < self.0.height
        {
            self.0.texels[y as usize * self.0.width as usize + x as usize] = opaque(colour);
        }
    }

    pub(super) fn fill(&mut self, x: i64, y: i64, width: i64, height: i64, colour: Colour) {
        for row in y..y + height {
            for column in x..x + width {
                self.set(column, row, colour);
            }
        }
    }

    /// A frame one pixel outside of an area.
    pub(super) fn frame(&mut self, x: i64, y: i64, width: i64, height: i64) {
        self.fill(x - 1, y - 1, width + 2, 1, INK);
        self.fill(x - 1, y + height, width + 2, 1, INK);
        self.fill(x - 1, y - 1, 1, height + 2, INK);
        self.fill(x + width, y - 1, 1, height + 2, INK);
    }

    /// A label; `x` is its left end, centre or right end, `y` its top.
    pub(super) fn label(&mut self, text: &str, x: i64, y: i64, align: Align) {
        let width = text.chars().count() as i64 * ADVANCE - FONT_SCALE;
        let left = match align {
            Align::Left => x,
            Align::Centre => x - width / 2,
            Align::Right => x - width,
        };
        for (i, character) in text.chars().enumerate() {
            for (row, bits) in font::glyph(character).into_iter().enumerate() {
                for column in 0..font::WIDTH {
                    if bits >> (font::WIDTH - 1 - column) & 1 == 1 {
                        let at = left + i as i64 * ADVANCE + column as i64 * FONT_SCALE;
                        self.fill(at, y + row as i64 * FONT_SCALE, FONT_SCALE, FONT_SCALE, INK);
                    }
                }
            }
        }
    }

    /// The picture as PNG.
    pub(super) fn png(&self) -> Result<Vec<u8>> {
        encode::png(&self.0)
    }
}

fn opaque([r, g, b]: Colour) -> [u8; 4] {
    [r, g, b, 255]
}
